"""The survey that runs or ran last: how far it is, and what people call it."""

from __future__ import annotations

import json
import math
from typing import Optional, Tuple

from gpr20_common.message import Message
from gpr20_operator.robot.events import Progress
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.words import size_text, time_left
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_state import ENDED


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
    return Message(
        "line {number} of {count}",
        number=_line_number(parameters, target.y_mm),
        count=parameters.y_points,
    )


def _line_number(parameters: SurveyParameters, y_mm: float) -> int:
    span_mm = parameters.y_stop_mm - parameters.y_start_mm
    if span_mm == 0.0:
        return 1
    part = (y_mm - parameters.y_start_mm) / span_mm
    return min(max(round(part * (parameters.y_points - 1)), 0), parameters.y_points - 1) + 1


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
