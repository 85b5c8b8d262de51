"""The job that a window shows on every tab: how it is going, in words that cannot be confused."""

from __future__ import annotations

import enum
import json
import math
from dataclasses import dataclass
from typing import Dict, Optional, Tuple

from gpr20_common.message import Message
from gpr20_operator.robot.events import Progress
from gpr20_operator.robot.fault_messages import is_fault, is_notice, reason_of
from gpr20_operator.robot.health import AlarmKind
from gpr20_operator.robot.motion import TITLE, motion_of
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_operator.words import time_left
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_state import ENDED, SurveyState


def survey_name(description: str) -> Tuple[str, str]:
    """Return the id of a survey, and its name or its site; empty what it does not have.

    Args:
        description: The text of its survey.json.
    """
    try:
        values = json.loads(description)
        annotation = values.get("annotation") or {}
        name = annotation.get("name") or annotation.get("site") or ""
        return str(values.get("survey_id", "")), str(name)
    except (ValueError, AttributeError):
        # Who reads the plan from the same text reports what is wrong with it.
        return "", ""


class JobLevel(enum.Enum):
    """How it is going; each level has a colour, a sign and a pattern of its own."""

    WORKING = "working"
    PAUSED = "paused"
    ATTENTION = "attention"
    FAULT = "fault"
    DONE = "done"
    REST = "rest"


_LEVELS: Dict[SurveyState, JobLevel] = {
    SurveyState.CHECKING: JobLevel.WORKING,
    SurveyState.HOMING: JobLevel.WORKING,
    SurveyState.SURVEYING: JobLevel.WORKING,
    SurveyState.PAUSING: JobLevel.PAUSED,
    SurveyState.PAUSED: JobLevel.PAUSED,
    SurveyState.STOPPING: JobLevel.ATTENTION,
    SurveyState.FINISHED: JobLevel.DONE,
    SurveyState.FAILED: JobLevel.FAULT,
}
# Only in these does the time that is left pass.
_TIMED = (
    SurveyState.CHECKING,
    SurveyState.HOMING,
    SurveyState.SURVEYING,
    SurveyState.PAUSING,
)
_NO_CONTACT = (AlarmKind.MASTER_GONE, AlarmKind.NO_CONTROL, AlarmKind.CONTROL_LOST)


@dataclass(frozen=True)
class Job:
    """What a window shows of the job.

    Attributes:
        level: How it is going.
        title: The state in a word or two.
        message: What it does, or what is wrong.
        percent: How much is stored, rounded down; None: there is no survey, or it is not known.
        left: How long it still takes; None unless it is working.
        line: The line of the area that is measured, and how many there are; None: not known.
    """

    level: JobLevel
    title: Message
    message: Message
    percent: Optional[int] = None
    left: Optional[Message] = None
    line: Optional[Message] = None


def job_of(snapshot: Snapshot) -> Job:
    """Return what a window shows of the job now."""
    state = snapshot.state
    if state is None:
        level = JobLevel.REST if snapshot.alarm is None else JobLevel.FAULT
        return Job(level, Message("NO CONTACT"), _message(snapshot))
    progress = _progress(snapshot)
    return Job(
        _level(snapshot, state.code),
        _title(snapshot, state.code),
        _message(snapshot),
        None if progress is None else math.floor(progress.completion_percent),
        _left(snapshot, progress),
        line_of(snapshot),
    )


def band_of(snapshot: Snapshot) -> Job:
    """Return what the band on every tab shows: motion that no survey explains comes first."""
    job, motion = job_of(snapshot), motion_of(snapshot)
    if motion is None:
        return job
    level = JobLevel.FAULT if job.level is JobLevel.FAULT else JobLevel.ATTENTION
    return Job(level, TITLE, motion)


def time_passes(snapshot: Snapshot) -> bool:
    """Return whether the time that is left passes: not while the survey is paused or ended."""
    return snapshot.state is not None and snapshot.state.code in _TIMED and snapshot.control_alive


def line_of(snapshot: Snapshot) -> Optional[Message]:
    """Return which line of the area is measured; None if none is."""
    parameters, target = snapshot.job_parameters, snapshot.target
    if parameters is None or target is None or not snapshot.running:
        return None
    return Message(
        "line {number} of {count}",
        number=_line_number(parameters, target.y_mm),
        count=parameters.y_points,
    )


def area_of(parameters: SurveyParameters) -> Message:
    """Return the size of a survey's area."""
    return Message(
        "{width:g} x {height:g} mm",
        width=abs(parameters.x_stop_mm - parameters.x_start_mm),
        height=abs(parameters.y_stop_mm - parameters.y_start_mm),
    )


class JobScreen:
    """Decides whether the job or the plan of the next survey is shown.

    The job stays on the screen after its end until the operator plans the next survey.
    """

    def __init__(self) -> None:
        self._left = ""
        self.visible = False

    def note(self, snapshot: Snapshot) -> None:
        """Take what is known now."""
        state = snapshot.state
        if state is None:
            self.visible = False
        elif snapshot.running:
            self._left = ""
            self.visible = True
        else:
            self.visible = state.code in ENDED and state.survey_id != self._left

    def leave(self, snapshot: Snapshot) -> None:
        """Note that the operator plans the next survey; not while one is running."""
        if snapshot.state is not None and not snapshot.running:
            self._left = snapshot.state.survey_id
            self.note(snapshot)


def _level(snapshot: Snapshot, code: SurveyState) -> JobLevel:
    alarm = snapshot.alarm
    if alarm is not None and alarm.kind is not AlarmKind.ANALYZER_FAULT:
        return JobLevel.FAULT
    level = _LEVELS.get(code, JobLevel.REST)
    if code is SurveyState.STOPPED and snapshot.state and is_fault(snapshot.state):
        return JobLevel.FAULT
    kept = (JobLevel.FAULT, JobLevel.PAUSED)
    return JobLevel.ATTENTION if alarm is not None and level not in kept else level


def _title(snapshot: Snapshot, code: SurveyState) -> Message:
    kind = None if snapshot.alarm is None else snapshot.alarm.kind
    if kind in _NO_CONTACT:
        return Message("NO CONTACT")
    if kind is AlarmKind.SURVEY_INTERRUPTED:
        return Message("INTERRUPTED")
    return code.label


def _message(snapshot: Snapshot) -> Message:
    if snapshot.alarm is not None:
        return snapshot.alarm.message
    if snapshot.state is None:
        return Message("Waiting for the robot.")
    # The title says the state.
    message = snapshot.state.message
    return reason_of(message) if is_fault(snapshot.state) else message


def _progress(snapshot: Snapshot) -> Optional[Progress]:
    state, progress = snapshot.state, snapshot.progress
    if state is None or progress is None or not progress.total_points:
        return None
    if progress.survey_id != state.survey_id:
        return None
    return progress if snapshot.running or state.code in ENDED else None


def _left(snapshot: Snapshot, progress: Optional[Progress]) -> Optional[Message]:
    if progress is None or not time_passes(snapshot) or progress.is_complete:
        return None
    # A warning, or what is waited for, comes first.
    if snapshot.alarm is not None or snapshot.state is None or is_notice(snapshot.state):
        return None
    return time_left(progress.remaining_s)


def _line_number(parameters: SurveyParameters, y_mm: float) -> int:
    span_mm = parameters.y_stop_mm - parameters.y_start_mm
    if span_mm == 0.0:
        return 1
    part = (y_mm - parameters.y_start_mm) / span_mm
    return min(max(round(part * (parameters.y_points - 1)), 0), parameters.y_points - 1) + 1


def remaining(progress: Progress) -> Message:
    """Return the time that is left and its basis: the plan, or the points taken so far."""
    left = time_left(progress.remaining_s)
    if progress.visited_points == 0:
        return Message("{left} (by the plan)", left=left)
    return Message("{left} (measured)", left=left)
