"""The report of a survey beside its traces: coverage, repeat measurements, analyzers."""

from __future__ import annotations

import json
import threading
from dataclasses import dataclass, replace
from typing import Any, Dict, List, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_common.mid.codec import plain, record_from
from gpr20_main_control import faults
from gpr20_main_control.errors import OtherAnalyzerError, SurveyError
from gpr20_main_control.mid.survey.repeats import Repeated
from gpr20_main_control.mid.survey.survey_coverage import Coverage
from gpr20_main_control.mid.survey.zero_record import ZeroRecord
from gpr20_main_control.mid.sweep_difference import finite
from gpr20_survey.faults import VNA_REPLACED
from gpr20_survey.folder.survey_metadata import FAULT_CODE, REASON_MESSAGE, message_record
from gpr20_survey.plan.survey_state import COVERAGE_LETTERS
from gpr20_survey.plan.zero_history import ZEROS, Proof, UsedZeros
from gpr20_survey.results.reopened_survey import ReopenedSurvey
from gpr20_survey.trace.utc_time import iso_text

# Place of the serial number in an identity: maker, model, serial number, firmware.
SERIAL_NUMBER = 2
# The report is bounded, however often an instrument fails; each trace has its own remarks.
MAX_WARNINGS = 1000


@dataclass(frozen=True)
class UsedAnalyzer:
    """An analyzer of a survey.

    Attributes:
        identity: What the instrument says it is.
        from_index: Index of the first point that was measured with it.
        accepted: When the survey began with it, ISO 8601; None if not recorded.
    """

    identity: str
    from_index: int
    accepted: Optional[str]


class AnalyzerRecord:
    """The analyzers of one survey. Another one is used only if the operator accepts it.

    Attributes:
        accept: Identity of the analyzer that the operator accepts at the next check; empty if
            none. Each check ends it.
        checked: Set when an analyzer was checked and may be used.
    """

    def __init__(self, used: Sequence[UsedAnalyzer]) -> None:
        """Begin, or continue, a record."""
        self.accept = ""
        self.checked = threading.Event()
        self._used = list(used)

    @property
    def used(self) -> List[UsedAnalyzer]:
        """The analyzers so far, in order."""
        return list(self._used)

    def check(self, identity: str, next_index: int, now_us: int) -> None:
        """Return if the survey may be measured with an analyzer, and note it if it is new.

        Raises:
            OtherAnalyzerError: It is another one, and the operator has not accepted it.
        """
        accept, self.accept = self.accept, ""
        former = self._used[-1].identity if self._used else identity
        other = _serial_number(identity) != _serial_number(former)
        if accept and accept != identity:
            raise OtherAnalyzerError(
                Message(
                    "the VNA is {present}, not {accepted}, which was accepted",
                    present=identity,
                    accepted=accept,
                ),
                identity if other else "",
                VNA_REPLACED,
            )
        if other and not accept:
            raise OtherAnalyzerError(
                Message(
                    "the VNA is {present}, but the survey was measured with {former}; connect "
                    "that VNA again, or accept the other one when you resume the survey",
                    present=identity,
                    former=former,
                ),
                identity,
            )
        if other or not self._used:
            self._used.append(UsedAnalyzer(identity, next_index, iso_text(now_us)))
        self.checked.set()


def _serial_number(identity: str) -> str:
    fields = [one.strip() for one in identity.split(",")]
    return fields[SERIAL_NUMBER] if len(fields) > SERIAL_NUMBER else identity


@dataclass(frozen=True)
class Control:
    """A stored point that was measured again, and its difference from the trace."""

    index: int
    time: str
    difference_db: Optional[float]
    height_difference_m: Optional[float]


@dataclass(frozen=True)
class FormerReport:
    """What the last report of a survey on the disk says."""

    controls: Tuple[Control, ...] = ()
    warnings: Tuple[Dict[str, Any], ...] = ()
    analyzers: Tuple[UsedAnalyzer, ...] = ()
    zeros: Tuple[UsedZeros, ...] = ()


def former_report(reopened: Optional[ReopenedSurvey]) -> FormerReport:
    """Return what a survey on the disk says of itself; None: a new survey says nothing.

    Raises:
        SurveyError: Its report cannot be read.
    """
    if reopened is None:
        return FormerReport()
    try:
        values = json.loads(reopened.report_json) if reopened.report_json else {}
        former = record_from(FormerReport, values, "report", others=True)
    except ValueError as error:
        raise _unreadable(repr(error)) from error
    analyzers = former.analyzers
    if not analyzers:
        # Before the first report there is only the analyzer of the start.
        instrument = json.loads(reopened.metadata_json).get("instrument")
        identity = instrument.get("identity") if isinstance(instrument, dict) else None
        analyzers = (UsedAnalyzer(identity, 0, None),) if isinstance(identity, str) else ()
    zeros, last = former.zeros, reopened.recent[-1] if reopened.recent else None
    if last is not None and last.zeros and all(one.zeros != last.zeros for one in zeros):
        # A survey that was cut off before its first report began with these.
        first = UsedZeros(last.zeros, 0, "", Proof.START)
        zeros = (
            *zeros,
            replace(first, from_index=last.index, proof=Proof.ACCEPTED) if zeros else first,
        )
    return replace(former, analyzers=analyzers, zeros=zeros)


class SurveyReport:
    """Collects the report of a survey, an entry of its log."""

    def __init__(
        self,
        coverage: Coverage,
        analyzers: AnalyzerRecord,
        zeros: ZeroRecord,
        former: FormerReport,
    ) -> None:
        """Begin, or continue, a report.

        Raises:
            SurveyError: The former report is not of this plan.
        """
        self.coverage = coverage
        self._analyzers = analyzers
        self._zeros = zeros
        self._controls, self._warnings = list(former.controls), list(former.warnings)
        for control in self._controls:
            if not 0 <= control.index < coverage.planned:
                raise _unreadable("a repeat measurement is not of a planned sample")
            coverage.note_remeasured(control.index)

    def note_repeat(self, repeated: Repeated, time_us: int) -> None:
        """Note that a stored point was measured again, and its difference from the trace."""
        self._controls.append(
            Control(
                repeated.stored.index,
                iso_text(time_us),
                finite(repeated.difference_db),
                finite(repeated.height_difference_m),
            )
        )
        self.coverage.note_remeasured(repeated.stored.index)

    def note_warning(self, warning: Message, time_us: int) -> None:
        """Note a warning about the recording."""
        if len(self._warnings) >= MAX_WARNINGS:
            return
        self._warnings.append(
            {
                "time": iso_text(time_us),
                "warning": str(warning),
                "warning_message": message_record(warning),
                FAULT_CODE: warning.fault_code,
            }
        )

    def to_json(self) -> str:
        """Return the report as the log stores it.

        `coverage` has one letter per planned sample, in the order of the plan: m measured,
        r measured again, f failed, - not visited. Sentences are stored twice: as English text,
        and as template and values for clients that translate them.
        """
        verdict = self.coverage.verdict()
        reasons = sorted(self.coverage.reasons.items())
        return json.dumps(
            {
                "complete": verdict.complete,
                "verdict": str(verdict.message),
                "verdict_message": message_record(verdict.message),
                "coverage": "".join(COVERAGE_LETTERS[state] for state in self.coverage.states),
                "failed": [
                    {
                        "index": index,
                        "reason": str(reason),
                        REASON_MESSAGE: message_record(reason),
                        FAULT_CODE: reason.fault_code,
                    }
                    for index, reason in reasons
                ],
                "controls": plain(self._controls),
                "warnings": self._warnings,
                "analyzers": plain(self._analyzers.used),
                ZEROS: plain(self._zeros.used),
            }
        )


def _unreadable(details: str) -> SurveyError:
    return SurveyError(
        Message("the report in the log cannot be read; plan a new survey", details=details),
        fault=faults.RECORD_DAMAGED,
    )
