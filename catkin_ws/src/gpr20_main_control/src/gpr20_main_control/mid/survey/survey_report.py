"""What is kept of a survey beside its traces: coverage, warnings, analyzers, zeros; its clock."""

from __future__ import annotations

import json
import threading
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain, record_from
from gpr20_main_control.errors import (
    MOVED_BY_OTHERS,
    RECORD_DAMAGED,
    DeviceError,
    OtherAnalyzerError,
    SurveyError,
)
from gpr20_main_control.mid.devices.robot import zeros_of
from gpr20_main_control.mid.measured_again import KnownPoint
from gpr20_main_control.mid.survey.survey_status import Coverage
from gpr20_survey.axes import AxisId, AxisParameters, ZeroEpoch, Zeros
from gpr20_survey.faults import CLOCK_WRONG, OTHER_ZEROS
from gpr20_survey.folder.survey_metadata import FAULT_CODE, message_record
from gpr20_survey.plan.recorded_plan import UNPROVEN, ZEROS, Proof, UsedZeros
from gpr20_survey.plan.survey_state import COVERAGE_LETTERS
from gpr20_survey.trace.sweep import storable_remark
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.utc_time import iso_text

# Place of the serial number in an identity: maker, model, serial number, firmware.
SERIAL_NUMBER = 2
# The report is bounded, however often an instrument fails; each trace has its own remarks.
MAX_WARNINGS = 1000
# Less than this is how a time server usually corrects a clock [s].
LARGEST_CORRECTION_S = 2.0

ByAxis = Mapping[AxisId, ZeroEpoch]


class ClockSteps:
    """Notices that the computer's clock was set, by one that nobody sets."""

    def __init__(
        self, clock: Clock, last: Optional[Trace], on_step: Callable[[Message], None]
    ) -> None:
        """Begin to compare, with the trace that was stored last, perhaps by another session."""
        self._clock = clock
        self._on_step = on_step
        self._offset_s = self._offset_now_s()
        if last is not None:
            # Behind that trace is as if it had been set back since.
            self._offset_s = max(self._offset_s, 1.0e-6 * last.timestamp_us - clock.now_s())

    def check(self) -> None:
        """Report by how much the clock was set since the last check, if it was."""
        offset_s = self._offset_now_s()
        step_s, self._offset_s = offset_s - self._offset_s, offset_s
        if abs(step_s) > LARGEST_CORRECTION_S:
            message = Message(
                "the computer's clock was set by {step_s:+.0f} s during the survey; times in the "
                "recording are out of order, or durations too long",
                step_s=step_s,
            )
            self._on_step(message.with_fault(CLOCK_WRONG.as_warning()))

    def _offset_now_s(self) -> float:
        return 1.0e-6 * self._clock.time_of_day_us() - self._clock.now_s()


@dataclass(frozen=True)
class UsedAnalyzer:
    """An analyzer of a survey, since its first point, which was accepted then (ISO 8601)."""

    identity: str
    from_index: int
    accepted: Optional[str]


class AnalyzerRecord:
    """The analyzers of one survey. Another one is used only if the operator accepts it.

    Attributes:
        used: The analyzers so far, in order.
        accept: Identity of the analyzer that the operator accepts at the next check; empty if
            none. Each check ends it.
        checked: Set when an analyzer was checked and may be used.
    """

    def __init__(self, used: Sequence[UsedAnalyzer]) -> None:
        """Begin, or continue, a record."""
        self.accept = ""
        self.checked = threading.Event()
        self.used: List[UsedAnalyzer] = list(used)

    def check(self, identity: str, next_index: int, now_us: int) -> None:
        """Note an analyzer; refuse another one that the operator has not accepted."""
        accept, self.accept = self.accept, ""
        former = self.used[-1].identity if self.used else identity
        other = _serial_number(identity) != _serial_number(former)
        if other and accept != identity:
            raise OtherAnalyzerError(
                Message(
                    "the VNA is {present}, but the survey was measured with {former}; connect "
                    "that VNA again, or accept the other one when you resume the survey",
                    present=identity,
                    former=former,
                ),
                identity,
            )
        if other or not self.used:
            self.used.append(UsedAnalyzer(identity, next_index, iso_text(now_us)))
        self.checked.set()


def _serial_number(identity: str) -> str:
    fields = [one.strip() for one in identity.split(",")]
    return fields[SERIAL_NUMBER] if len(fields) > SERIAL_NUMBER else identity


class ZeroRecord:
    """The zeros that the traces of one survey refer to, and how each was proven.

    Attributes:
        accept: Whether the operator accepts the next zeros, if they are those of the last question.
        used: The zeros so far, in their order.
    """

    def __init__(
        self, used: Sequence[UsedZeros], parameters: Mapping[AxisId, AxisParameters]
    ) -> None:
        """Begin, or continue, a record."""
        self.accept = False
        self._asked: Optional[Zeros] = None
        self.used: List[UsedZeros] = list(used)
        self._parameters = parameters
        # Since the survey homed the axes last; the leases keep others from homing them meanwhile.
        self._homed: Zeros = ()

    def to_home_again(self, present: ByAxis) -> List[AxisId]:
        """Return the axes that somebody else homed and whose zero this survey can find itself."""
        former = zip(AxisId, self._homed)
        return [
            axis_id
            for axis_id, zero in former
            if self._parameters[axis_id].finds_zero and present[axis_id] != zero
        ]

    def note_homed(self, present: ByAxis) -> None:
        """Note the zeros since every axis is homed; where needed, by this survey."""
        self._homed = zeros_of(present)

    def needs_proof(self, present: ByAxis) -> bool:
        """Return whether these are other zeros than those of the traces."""
        return not self.used or self.used[-1].zeros != zeros_of(present)

    def begin(self, present: ByAxis, next_index: int, time: str) -> None:
        """Take the zeros as they are: there is no trace of others."""
        self.used = [UsedZeros(zeros_of(present), next_index, time, Proof.START)]

    def judge(
        self, present: ByAxis, point: KnownPoint, limit_db: float, next_index: int, time: str
    ) -> None:
        """Take other zeros, if a known point within a limit [dB], or the operator, says so."""
        by_hand, agrees = self._set_by_hand(present), point.agrees(limit_db)
        zeros = zeros_of(present)
        accepted = self.accept and self._asked in (None, zeros)
        self.accept = False
        if agrees and not by_hand:
            # Agreeing with traces that nothing proves proves nothing.
            unproven = bool(self.used) and self.used[-1].proof is Proof.ACCEPTED
            proof = Proof.ACCEPTED if unproven else Proof.MEASURED
        elif accepted:
            proof = Proof.ACCEPTED
        else:
            self._asked = zeros
            raise DeviceError(_question(by_hand, agrees, point), fault=OTHER_ZEROS)
        self.used.append(UsedZeros(zeros, next_index, time, proof))

    def check(self, present: Zeros) -> None:
        """Raise a DeviceError unless these are the zeros since the axes were homed."""
        if self._homed == present:
            return
        pairs = zip(AxisId, self._homed, present)
        raise DeviceError(
            Message(
                "the zero of the {axes} axis was found or set again by somebody else; resume the "
                "survey to compare a known point",
                axes=", ".join(axis_id.value for axis_id, one, other in pairs if one != other),
            ),
            fault=MOVED_BY_OTHERS,
        )

    @property
    def remark(self) -> Tuple[str, ...]:
        """The remark on the quality of traces whose zeros nobody has proven; empty if proven."""
        if not self.used or self.used[-1].proof is not Proof.ACCEPTED:
            return ()
        return (storable_remark(str(UNPROVEN)),)

    def _set_by_hand(self, present: ByAxis) -> List[AxisId]:
        """Return the axes whose zero nothing finds, and that have another one than the traces.

        A homing only turns such an axis to the zero that it knows.
        """
        former = zip(AxisId, self.used[-1].zeros if self.used else ())
        return [
            axis_id
            for axis_id, zero in former
            if not self._parameters[axis_id].finds_zero and zero.time_us != present[axis_id].time_us
        ]


def _question(by_hand: Sequence[AxisId], agrees: bool, point: KnownPoint) -> Message:
    if agrees:
        return Message(
            "the zero of the {axes} axis was set by hand; a known point agrees, which does not "
            "prove where the zero is: {repeat}",
            axes=", ".join(one.value for one in by_hand),
            repeat=point.message,
        )
    if point.turned:
        return Message(
            "the antennas seem to be turned: a known point fits another rotation better; {repeat}",
            repeat=point.message,
        )
    return Message(
        "after homing, a known point does not agree with its stored traces: {repeat}",
        repeat=point.message,
    )


@dataclass(frozen=True)
class _Former:
    """What the last report of a survey on the disk says."""

    warnings: Tuple[Dict[str, Any], ...] = ()
    analyzers: Tuple[UsedAnalyzer, ...] = ()
    zeros: Tuple[UsedZeros, ...] = ()


class SurveyReport:
    """The report of a survey, an entry of its log.

    Attributes:
        coverage: The state of each planned sample.
        analyzers: With which analyzers it is measured.
        zeros: To which zeros of the axes its traces refer.
    """

    def __init__(
        self, coverage: Coverage, axes: Mapping[AxisId, AxisParameters], former_json: str = ""
    ) -> None:
        """Begin a report, or continue the one that is stored, if that can be read."""
        try:
            former = record_from(_Former, json.loads(former_json or "{}"), "report", others=True)
        except ValueError as error:
            raise SurveyError(
                Message("the report in the log cannot be read; plan a new survey", details=error),
                fault=RECORD_DAMAGED,
            ) from error
        self.coverage = coverage
        self.analyzers = AnalyzerRecord(former.analyzers)
        self.zeros = ZeroRecord(former.zeros, axes)
        self._warnings = list(former.warnings)

    def note_warning(self, warning: Message) -> None:
        """Note a warning, with which the survey continues, whatever it is."""
        warning = warning.as_warning()
        if len(self._warnings) < MAX_WARNINGS:
            record = {"warning": str(warning), "warning_message": message_record(warning)}
            time = iso_text(time_of_day_us())
            self._warnings.append({"time": time, **record, FAULT_CODE: warning.fault_code})

    def to_json(self, ended: bool) -> str:
        """Return the report as the log stores it; of a survey that has ended, with its coverage.

        `coverage` has one letter per planned sample, in the order of the plan: m measured,
        f failed, - not visited. Warnings are stored twice: as English text, and as template and
        values for clients that translate them.
        """
        report = {
            "warnings": self._warnings,
            "analyzers": plain(self.analyzers.used),
            ZEROS: plain(self.zeros.used),
        }
        if ended:
            report.update(
                complete=self.coverage.verdict().complete,
                coverage="".join(COVERAGE_LETTERS[state] for state in self.coverage.states),
            )
        return json.dumps(report)
