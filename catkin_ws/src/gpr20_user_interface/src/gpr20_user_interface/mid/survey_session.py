"""Follow a survey on a terminal."""

from __future__ import annotations

from typing import List, Optional, Protocol

from gpr20_user_interface.mid.displays import time_text
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


class Events(Protocol):
    """What happens, in its order."""

    def next(self, timeout_s: float) -> Optional[Event]:
        """Wait for the next event for at most `timeout_s` [s]; None if there was none."""


class Control(Protocol):
    """main_control, as something that can be asked; its answers come as events."""

    def send(self, request: Request) -> None:
        """Ask without waiting for the answer."""


class Display(Protocol):
    """Where the operator looks."""

    def note(self, text: str) -> None:
        """Show a sentence of the client."""

    def status(self, state: ControlState) -> None:
        """Show what main_control does."""

    def progress(self, progress: Progress) -> None:
        """Show how far the survey is."""

    def close(self) -> None:
        """Leave the terminal ready for plain lines."""


class SurveySession:
    """Carries events to the watch, its requests to main_control and the news to the display."""

    def __init__(
        self, watch: SurveyFollower, events: Events, control: Control, display: Display
    ) -> None:
        self._watch = watch
        self._events = events
        self._control = control
        self._display = display
        self._simulated = False
        self._complete = False
        self._stored = False

    @property
    def simulated(self) -> bool:
        """Whether main_control said that the robot is simulated."""
        return self._simulated

    @property
    def stored(self) -> bool:
        """Whether a trace of the survey is stored, so that it can be resumed."""
        return self._stored

    def run(self) -> Outcome:
        """Return how the survey ended, when it has."""
        try:
            while self._watch.outcome is None:
                event = self._events.next(TICK_S)
                requests = self._watch.tick() if event is None else self._watch.handle(event)
                if event is not None:
                    self._show(event)
                for request in requests:
                    self._control.send(request)
            if self._watch.outcome.status is ExitStatus.FINISHED:
                self._show_last_progress()
        finally:
            self._display.close()
        return self._watch.outcome

    def _show_last_progress(self) -> None:
        """Show the last trace too: progress and end are different topics and come in any order."""
        for _ in range(LAST_WORDS):
            if self._complete:
                return
            event = self._events.next(TICK_S)
            if isinstance(event, Progress) and self._watch.concerns(event):
                self._show_progress(event)

    def _show_progress(self, progress: Progress) -> None:
        self._complete = progress.visited_points >= progress.total_points > 0
        self._stored = progress.visited_points > 0
        self._display.progress(progress)

    def _show(self, event: Event) -> None:
        if isinstance(event, ControlState) and event.simulated and not self._simulated:
            self._simulated = True
            self._display.note(SIMULATED)
        if self._watch.outcome is not None or not self._watch.concerns(event):
            return
        if isinstance(event, ControlState):
            self._display.status(event)
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
