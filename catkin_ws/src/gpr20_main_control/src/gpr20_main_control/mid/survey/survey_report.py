"""What is kept of a survey beside its traces: coverage, warnings, analyzers, zeros; its clock."""

from __future__ import annotations

import json
import threading
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain, record_from
from gpr20_main_control import faults
from gpr20_main_control.errors import OtherAnalyzerError, SurveyError
from gpr20_main_control.mid.survey.survey_status import Coverage
from gpr20_main_control.mid.survey.zero_record import ZeroRecord
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.folder.survey_metadata import FAULT_CODE, REASON_MESSAGE, message_record
from gpr20_survey.plan.survey_state import COVERAGE_LETTERS
from gpr20_survey.plan.zero_history import ZEROS, UsedZeros
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.utc_time import iso_text

# Place of the serial number in an identity: maker, model, serial number, firmware.
SERIAL_NUMBER = 2
# The report is bounded, however often an instrument fails; each trace has its own remarks.
MAX_WARNINGS = 1000
# Less than this is how a time server usually corrects a clock [s].
LARGEST_CORRECTION_S = 2.0


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
        """Return if the survey may be measured with an analyzer, and note it if it is new.

        Raises:
            OtherAnalyzerError: It is another one, and the operator has not accepted it.
        """
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
        """Begin a report, or continue the one that is stored.

        Raises:
            SurveyError: That one cannot be read.
        """
        try:
            former = record_from(_Former, json.loads(former_json or "{}"), "report", others=True)
        except ValueError as error:
            raise SurveyError(
                Message("the report in the log cannot be read; plan a new survey", details=error),
                fault=faults.RECORD_DAMAGED,
            ) from error
        self.coverage = coverage
        self.analyzers = AnalyzerRecord(former.analyzers)
        self.zeros = ZeroRecord(former.zeros, axes)
        self._warnings = list(former.warnings)

    def note_warning(self, warning: Message) -> None:
        """Note a warning about the recording."""
        if len(self._warnings) < MAX_WARNINGS:
            record = {"warning": str(warning), "warning_message": message_record(warning)}
            time = iso_text(time_of_day_us())
            self._warnings.append({"time": time, **record, FAULT_CODE: warning.fault_code})

    def to_json(self, ended: bool) -> str:
        """Return the report as the log stores it; of a survey that has ended, with its coverage.

        `coverage` has one letter per planned sample, in the order of the plan: m measured,
        f failed, - not visited. Sentences are stored twice: as English text, and as template and
        values for clients that translate them.
        """
        report = {
            "warnings": self._warnings,
            "analyzers": plain(self.analyzers.used),
            ZEROS: plain(self.zeros.used),
        }
        if ended:
            verdict = self.coverage.verdict()
            report.update(
                complete=verdict.complete,
                verdict=str(verdict.message),
                verdict_message=message_record(verdict.message),
                coverage="".join(COVERAGE_LETTERS[state] for state in self.coverage.states),
                failed=[
                    {
                        "index": index,
                        "reason": str(reason),
                        REASON_MESSAGE: message_record(reason),
                        FAULT_CODE: reason.fault_code,
                    }
                    for index, reason in sorted(self.coverage.reasons.items())
                ],
            )
        return json.dumps(report)
