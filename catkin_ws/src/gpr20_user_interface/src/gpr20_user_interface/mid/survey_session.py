"""Follow a survey on a terminal."""

from __future__ import annotations

import queue
from typing import Callable, List, Optional

from gpr20_user_interface.mid.displays import Display, time_text
from gpr20_user_interface.mid.events import (
    Accepted,
    Answer,
    ControlState,
    Event,
    Progress,
    Request,
    StopRequested,
)
from gpr20_user_interface.mid.survey_follower import ExitStatus, Outcome, SurveyFollower

TICK_S = 0.2
# Words of main_control, or ticks, that the progress of a finished survey may be behind its end.
LAST_WORDS = 20

SIMULATED = "SIMULATED robot: these data show no real ground"

_HEADLINES = {
    ExitStatus.FINISHED: "survey finished",
    ExitStatus.REFUSED: "no survey was run",
    ExitStatus.FAILED: "survey NOT finished",
    ExitStatus.PAUSED: "survey PAUSED and left so",
    ExitStatus.STOPPED: "survey stopped",
}
_RESUME_HINT = (
    "resume it with `rosrun gpr20_user_interface run_survey --resume`, "
    "or end it with `rosservice call stop_survey` (in the robot's namespace)"
)
_LATER_HINT = (
    "measure what is missing, when no survey runs, with "
    "`rosrun gpr20_user_interface run_survey --resume {}`"
)


class SurveySession:
    """Carries events to the follower, its requests to main_control and the news to the display.

    Args:
        follower: Knows what an event means for the survey.
        events: What happens, in its order.
        send: Asks main_control without waiting; its answers come as events.
        display: Where the operator looks.

    Attributes:
        simulated: Whether main_control said that the robot is simulated.
        stored: Whether a trace of the survey is stored, so that it can be resumed.
    """

    def __init__(
        self,
        follower: SurveyFollower,
        events: queue.SimpleQueue,
        send: Callable[[Request], None],
        display: Display,
    ) -> None:
        self._follower = follower
        self._events = events
        self._send = send
        self._display = display
        self.simulated = False
        self._state: Optional[ControlState] = None
        self._progress: Optional[Progress] = None
        self.stored = False

    def run(self) -> Outcome:
        """Return how the survey ended, when it has."""
        try:
            while self._follower.outcome is None:
                event = self._next_event()
                requests = self._follower.tick() if event is None else self._follower.handle(event)
                if event is not None:
                    self._show(event)
                for request in requests:
                    self._send(request)
            if self._follower.outcome.status is ExitStatus.FINISHED:
                self._show_last_progress()
        finally:
            self._display.close()
        return self._follower.outcome

    def _next_event(self) -> Optional[Event]:
        try:
            return self._events.get(timeout=TICK_S)
        except queue.Empty:
            return None

    def _show_last_progress(self) -> None:
        """Show the last trace too: progress and end are different topics and come in any order."""
        for _ in range(LAST_WORDS):
            if self._progress is not None and self._progress.is_complete:
                return
            event = self._next_event()
            if isinstance(event, Progress) and self._follower.concerns(event):
                self._show_progress(event)

    def _show_progress(self, progress: Progress) -> None:
        self._progress = progress
        self.stored = progress.visited_points > 0
        self._display.show(progress, self._state)

    def _show_state(self, state: ControlState) -> None:
        if state == self._state:
            return
        self._state = state
        self._display.note(f"{state.code.name}: {state.message}")
        if self._progress is not None:
            self._display.show(self._progress, state)

    def _show(self, event: Event) -> None:
        if isinstance(event, ControlState) and event.simulated and not self.simulated:
            self.simulated = True
            self._display.note(SIMULATED)
        if self._follower.outcome is not None or not self._follower.concerns(event):
            return
        if isinstance(event, ControlState):
            self._show_state(event)
        elif isinstance(event, Progress):
            self._show_progress(event)
        elif isinstance(event, Accepted):
            self._display.note(_accepted_text(event))
        elif isinstance(event, StopRequested):
            self._display.note(f"{event.reason}: asking main_control to stop the survey")
        elif isinstance(event, Answer) and event.request is Request.STOP and not event.success:
            self._display.note(f"stop not accepted: {event.message}")


def _accepted_text(plan: Accepted) -> str:
    return f"parameters accepted: {plan.total_points} traces, about {time_text(plan.estimated_s)}"


def outcome_lines(
    outcome: Outcome, survey_id: str, simulated: bool, stored: bool = False
) -> List[str]:
    """Return the last words of the client.

    Args:
        outcome: How it ended.
        survey_id: Of the survey; empty if there was none.
        simulated: Whether the robot is.
        stored: Whether a trace of the survey is stored.
    """
    lines = [_HEADLINES[outcome.status], outcome.message]
    if survey_id:
        lines.append(f"survey id: {survey_id}")
    if outcome.status is ExitStatus.PAUSED:
        lines.append(_RESUME_HINT)
    elif outcome.status in (ExitStatus.STOPPED, ExitStatus.FAILED) and stored:
        lines.append(_LATER_HINT.format(survey_id))
    if simulated:
        lines.append(SIMULATED)
    return lines
