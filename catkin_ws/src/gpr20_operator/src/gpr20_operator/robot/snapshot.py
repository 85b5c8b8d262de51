"""Everything that is known of the robot and its survey at one moment."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import FrozenSet, Optional, Tuple

from gpr20_common.message import Message
from gpr20_doctor.mid.node_health import HealthReport
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.events import (
    Configured,
    ControlState,
    CurrentPosition,
    Progress,
    Replay,
    Request,
    TargetPosition,
)
from gpr20_operator.words import size_text, time_left
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_state import ENDED, SurveyState

# The main control publishes at 2 Hz; over a link that loses packets, it may be late by seconds.
CONTROL_SILENCE_S = 5.0
# A coordinate or height that is older than this [s] is not shown.
STALE_S = 3.0


@dataclass(frozen=True)
class Snapshot:
    """What a client shows; None: not known now."""

    control_alive: bool
    control_silent_s: Optional[float] = None
    state: Optional[ControlState] = None
    progress: Optional[Progress] = None
    current: Optional[CurrentPosition] = None
    target: Optional[TargetPosition] = None
    height_m: Optional[float] = None
    pending: FrozenSet[Request] = frozenset()
    robot: Optional[Configured] = None
    # The parameters of the survey that runs or ran last, whoever started it.
    job_parameters: Optional[SurveyParameters] = None
    health: HealthReport = field(default_factory=HealthReport)
    master_alive: bool = True
    # A survey ran, and the main control does not know it any more.
    interrupted: bool = False
    # How long ago the state changed [s].
    state_s: float = math.inf
    # For how long no axis moved, no trace was counted and the state stayed the same [s].
    still_s: float = 0.0
    # What is done for maintenance, outside a survey.
    service: Optional[Message] = None
    # The last report of each axis that was heard.
    axes: Tuple[AxisReport, ...] = ()
    # What is shown was recorded; None: there is a robot.
    replay: Optional[Replay] = None

    @property
    def code(self) -> Optional[SurveyState]:
        """The last state of the main control."""
        return None if self.state is None else self.state.code

    @property
    def running(self) -> bool:
        """Whether, by the last status, a survey exists that has not ended."""
        return self.code is not None and self.code.running

    @property
    def survey_parameters(self) -> Optional[SurveyParameters]:
        """The parameters of the survey that runs."""
        return self.job_parameters if self.running else None

    @property
    def running_survey(self) -> str:
        """The id of the survey that has not ended; empty: there is none."""
        return self.state.survey_id if self.state is not None and self.running else ""

    @property
    def simulated(self) -> bool:
        """Whether the robot is simulated, or the survey that is replayed is of a simulated one."""
        return self.state is not None and self.state.simulated

    @property
    def fields_locked(self) -> bool:
        """Whether the parameters are those of a survey in progress."""
        return self.replay is not None or self.running or Request.START in self.pending

    @property
    def can_start(self) -> bool:
        """Whether START makes sense, if the parameters are right."""
        return self.control_alive and not self.fields_locked and self.service is None

    @property
    def moving(self) -> Tuple[AxisReport, ...]:
        """The axes that move by their last report, also if they are silent since."""
        return tuple(one for one in self.axes if one.moving)

    @property
    def paused(self) -> bool:
        """Whether the survey is paused."""
        return self.code is SurveyState.PAUSED

    @property
    def can_pause(self) -> bool:
        """Whether a survey is measuring and no request is pending."""
        return self.code is SurveyState.SURVEYING and self._takes_requests

    @property
    def can_resume(self) -> bool:
        """Whether a survey is paused that can continue, and no request is pending."""
        if self.state is None or not self.state.message.can_continue:
            return False
        return self.paused and self._takes_requests

    @property
    def _takes_requests(self) -> bool:
        return self.control_alive and not self.pending and not self.replay


def percent_of(snapshot: Snapshot) -> Optional[int]:
    """Return how much is stored, rounded down; None: there is no survey, or it is not known."""
    progress = progress_of(snapshot)
    return None if progress is None else math.floor(progress.completion_percent)


def progress_of(snapshot: Snapshot) -> Optional[Progress]:
    """Return how far the survey of the state is; None: there is no survey, or it is not known."""
    state, progress = snapshot.state, snapshot.progress
    if state is None or progress is None or not progress.total_points:
        return None
    if progress.survey_id != state.survey_id:
        return None
    return progress if snapshot.running or state.shown in ENDED else None


def line_of(snapshot: Snapshot) -> Optional[Message]:
    """Return the line of the area that is measured, and how many there are; None: none is."""
    parameters, target = snapshot.job_parameters, snapshot.target
    if parameters is None or target is None or not snapshot.running:
        return None
    span_mm = parameters.y_stop_mm - parameters.y_start_mm
    part = 0.0 if span_mm == 0.0 else (target.y_mm - parameters.y_start_mm) / span_mm
    line = min(max(round(part * (parameters.y_points - 1)), 0), parameters.y_points - 1)
    return Message("line {number} of {count}", number=line + 1, count=parameters.y_points)


def area_of(parameters: SurveyParameters) -> Message:
    """Return the size of a survey's area."""
    p = parameters
    return size_text(abs(p.x_stop_mm - p.x_start_mm), abs(p.y_stop_mm - p.y_start_mm))


def remaining(progress: Progress) -> Message:
    """Return the time that is left and its basis: the plan, or the points taken so far."""
    left = time_left(progress.remaining_s)
    if progress.visited_points == 0:
        return Message("{left} (by the plan)", left=left)
    return Message("{left} (measured)", left=left)


def survey_name(description: str) -> Tuple[str, str]:
    """Return id, and name or site, of a survey.json; empty what it does not have."""
    try:
        values = json.loads(description)
        annotation = values.get("annotation") or {}
        name = annotation.get("name") or annotation.get("site") or ""
        return str(values.get("survey_id", "")), str(name)
    except (ValueError, AttributeError):
        # Who reads the plan from the same text reports what is wrong with it.
        return "", ""


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
            self.visible = state.shown in ENDED and state.survey_id != self._left

    def leave(self, snapshot: Snapshot) -> None:
        """Note that the operator plans the next survey; not while one is running."""
        if snapshot.state is not None and not snapshot.running:
            self._left = snapshot.state.survey_id
            self.note(snapshot)
