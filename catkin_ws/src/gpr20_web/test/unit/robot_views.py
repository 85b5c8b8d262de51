"""What is known of a robot at one moment, and a clock that a test moves."""

from __future__ import annotations

from typing import Any, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Fault, Message, Severity
from gpr20_operator.robot.events import ControlState
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState

ASKED = Fault("survey.asked", severity=Severity.NOTE)
SILENT = Fault("vna.silent", Message("Check the cable of the VNA."))


class ManualClock(Clock):
    """Time passes when a test says so."""

    def __init__(self) -> None:
        self.time_s = 1000.0

    def now_s(self) -> float:
        """Return the time [s]."""
        return self.time_s

    def time_of_day_us(self) -> int:
        """Return the time of day [us]."""
        return int((1.8e9 + self.time_s) * 1e6)


def state_of(
    code: SurveyState, fault: Optional[Fault] = ASKED, survey: str = "s1", number: int = 0
) -> ControlState:
    """Return what the main control says; the number is in the sentence alone."""
    words = Message("it is as it is, {number} times", number=number).with_fault(fault)
    return ControlState(code, words, survey, True)


def view(state: Optional[ControlState], alive: bool = True, **other: Any) -> Snapshot:
    """Return what is known of a robot that reports nothing but its state."""
    values = {
        "control_alive": alive,
        "control_silent_s": 0.1 if alive else 7.9,
        "state": state,
        "progress": None,
        "current": None,
        "target": None,
        "height_m": None,
        "pending": frozenset(),
        "travel": None,
        **other,
    }
    return Snapshot(**values)
