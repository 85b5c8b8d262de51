"""What may not be believed of a survey: the one list that every reader, export and page shows.

It is attribute `doubts` of a Dataset, and the first notes of a verification and of a list of
candidates. Each doubt reports a fault, whose code says of which kind it is.
"""

from __future__ import annotations

import contextlib
import math
from pathlib import Path
from typing import Any, Iterable, Iterator, List, Mapping, Sequence, Set, Tuple

from gpr20_analysis import errors
from gpr20_analysis.dataset import mapping_of, objects_of
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.sources import open_source
from gpr20_analysis.read.survey_attributes import known_settings
from gpr20_analysis.read.traces import Sample
from gpr20_analysis.sentences import carried_doubts, first_of
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.sent_message import received_message
from gpr20_survey.axes import Zeros
from gpr20_survey.faults import DAMAGED
from gpr20_survey.folder.log_record import UNCONFIRMED, Kind, log_values
from gpr20_survey.folder.recovery import unconfirmed_message
from gpr20_survey.plan.recorded_plan import (
    TIMES_KNOWN,
    UNPROVEN,
    ZEROS,
    Proof,
    UsedZeros,
    import_of,
    import_sentence,
    is_imported,
)
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep import CalibrationStatus

Described = Mapping[str, Any]
REASONS, LISTED = 2, 5
"""Number of reasons that a doubt names, and of traces in one of them."""


def survey_doubts(
    description: Described, samples: Sequence[Sample], damaged: int = 0
) -> List[Message]:
    """Return the doubts, those of the positions first; of each kind one, or two.

    Args:
        description: The content of survey.json with the facts of its log, as far as known.
        samples: The samples in the order of their recording, or of their indices.
        damaged: Number of parts that are damaged and left out.
    """
    found = [
        *_positions(description, samples),
        *_unconfirmed(description, damaged),
        *_repeated(samples),
        *_calibration(description),
        *_drift(description),
        *_settings(description, samples),
        *_clock(description, samples),
        *_import(description),
    ]
    return list({str(one): one for one in found}.values())


def recording_doubts(path: Path) -> List[Message]:
    """Return the doubts of what a bag or an MCAP file holds; none of one that cannot be read."""
    with contextlib.suppress(AnalysisError):  # what can be read is written all the same
        source = open_source(path)
        samples = [Sample.of(one, row=0) for one in source.traces()]
        return survey_doubts(source.description or {}, samples, len(source.faults))
    return []


def unproven_count(description: Described, samples: Sequence[Sample]) -> int:
    """Return of how many traces nothing proves that their zeros are those of the others."""
    in_order = sorted(samples, key=lambda one: one.index)
    unproven = unproven_zeros(description.get("report"), (one["zeros"] for one in in_order))
    return sum(one["zeros"] in unproven or str(UNPROVEN) in one["quality"] for one in samples)


def _positions(description: Described, samples: Sequence[Sample]) -> Iterator[Message]:
    count = unproven_count(description, samples)
    if count:
        yield Message(
            "{count} traces refer to zeros of the axes that no measurement proved to be those of "
            "the others: their positions and rotations may be wrong",
            count=count,
        ).with_fault(errors.ZEROS_UNPROVEN)


def _unconfirmed(description: Described, damaged: int) -> Iterator[Message]:
    if damaged:
        yield Message(
            "{count} parts of the survey are damaged and left out", count=damaged
        ).with_fault(DAMAGED)
    entries = mapping_of(description, UNCONFIRMED)
    if entries:
        yield unconfirmed_message(entries)


def _repeated(samples: Sequence[Sample]) -> Iterator[Message]:
    count = len(samples) - len({one.content for one in samples})
    if count:
        yield Message(
            "{count} samples have exactly the values of another sample, which measured data never "
            "have; check whether the VNA returned one sweep twice",
            count=count,
        ).with_fault(errors.SWEEP_REPEATED)


def _calibration(description: Described) -> Iterator[Message]:
    status = mapping_of(description, "instrument").get("calibration_status")
    for one in set(CalibrationStatus) - {CalibrationStatus.HIGH}:
        if type(status) is int and one == status:
            yield Message(
                "calibration of the VNA at the start of the survey: {meaning}",
                meaning=one.meaning,
            ).with_fault(errors.CALIBRATION)


def _drift(description: Described) -> Iterator[Message]:
    exceeded = [one for one in log_values(description, Kind.DRIFT) if one.get("exceeded") is True]
    if exceeded:
        yield Message(
            "the drift exceeded {limit_db} dB or {limit_deg} deg at {count} visits of the first "
            "stop, for the first time before trace {index}",
            limit_db=str(exceeded[0].get("limit_db")),
            limit_deg=str(exceeded[0].get("limit_deg")),
            count=len(exceeded),
            index=str(exceeded[0].get("next_index")),
        ).with_fault(errors.DRIFTED)


def _settings(description: Described, samples: Sequence[Sample]) -> Iterator[Message]:
    for one in objects_of(mapping_of(description, "report"), "analyzers")[1:]:
        yield Message(
            "from trace {index} on another VNA measured: {identity}",
            index=str(one.get("from_index")),
            identity=str(one.get("identity")),
        ).with_fault(errors.SETTINGS_CHANGED)
    found = known_settings(samples)
    if len(found) > 1:
        (most, count), (other, _), *_others = found
        yield Message(
            "the samples were measured with different settings of the VNA: {count} with "
            "{settings}, {other_count} with others, such as {other}",
            count=count,
            settings=most.message,
            other_count=sum(number for _one, number in found[1:]),
            other=other.message,
        ).with_fault(errors.SETTINGS_CHANGED)


def unproven_zeros(report: Any, measured: Iterable[Zeros]) -> Set[Zeros]:
    """Return the zeros of traces that nothing proves to be those of the traces before.

    Args:
        report: As it was read; anything may stand there.
        measured: The zeros of the traces, in the order of their indices.
    """
    kind: Any = Tuple[UsedZeros, ...]
    used: Tuple[UsedZeros, ...] = ()
    with contextlib.suppress(InvalidValueError):
        listed = report.get(ZEROS) if isinstance(report, Mapping) else ()
        used = record_from(kind, listed, ZEROS)
    known = [one for one in measured if one]
    proven = {one.zeros for one in used if one.proof is not Proof.ACCEPTED}
    # Without a list, the zeros of the first trace are those of the survey.
    if not used and known:
        proven.add(known[0])
    return set(known) - proven


def _clock(description: Described, samples: Sequence[Sample]) -> Iterator[Message]:
    # What the robot noted of its clock, or an import of the times of its source.
    reasons = [
        received_message(str(values.get("text")), values.get("message"))
        for values in log_values(description, Kind.CLOCK)
    ]
    if is_imported(description) and import_of(description).get(TIMES_KNOWN) is not True:
        reasons.append(
            Message("the source names no times since 2020: the traces have that of the import")
        )
    started, ended = (_time_us(description.get(name)) for name in ("started", "ended"))
    if ended < started:
        reasons.append(Message("the end of the survey is before its start"))
    # Where a trace was measured again, or imported, later ones may have lower indices.
    ordered = not (description.get("resumed") or is_imported(description))
    wrong, before_us = [], 0
    for one in samples:
        begun_us, done_us = one["sweep_started_us"], one["timestamp_us"]
        if done_us < max(before_us, begun_us) or begun_us < started or done_us > ended:
            wrong.append(str(one.index))
        before_us = done_us if ordered else 0
    if wrong:
        listed = [*wrong[:LISTED], *(["..."] if len(wrong) > LISTED else [])]
        reasons.append(
            Message(
                "traces {indices} are older than what was before them, or not between start and "
                "end of the survey",
                indices=", ".join(listed),
            )
        )
    if reasons:
        yield Message(
            "times may be wrong: {reasons}", reasons=first_of(reasons, REASONS)
        ).reporting_only(errors.CLOCK)


def _import(description: Described) -> Iterator[Message]:
    if is_imported(description):
        yield Message(
            "{imported}, without a plan: nothing says what is missing",
            imported=import_sentence(description),
        ).with_fault(errors.IMPORTED)
        yield from carried_doubts(import_of(description))


def _time_us(text: object) -> float:
    """Return a moment [us since 1970]; NaN, which contradicts nothing, if there is none."""
    try:
        return utc_time.parse_iso(text)  # type: ignore[arg-type]
    except (TypeError, InvalidValueError):
        return math.nan
