"""Follow a survey on a terminal."""

from __future__ import annotations

import queue
import shlex
from typing import Callable, List, Optional, Sequence, Union

from gpr20_common.message import Message, Severity
from gpr20_operator.robot.events import (
    Accepted,
    Answer,
    ControlState,
    LinkState,
    Progress,
    Request,
    StopRequested,
)
from gpr20_operator.robot.notices import remedy
from gpr20_operator.robot.replay_model import ReplayModel
from gpr20_operator.words import duration
from gpr20_survey.faults import OTHER_ZEROS
from gpr20_survey.plan.survey_state import ENDED
from gpr20_user_interface.terminal.displays import PlainDisplay
from gpr20_user_interface.terminal.follower import ExitStatus, Outcome, SurveyFollower

TICK_S = 0.2
# Messages, or ticks, by which the progress of a finished survey may lag behind its end.
LAST_EVENTS = 20

SIMULATED = Message("SIMULATED robot: these data show no real ground.")

_HEADLINES = {
    ExitStatus.FINISHED: Message("Survey finished."),
    ExitStatus.REFUSED: Message("No survey was run."),
    ExitStatus.FAILED: Message("Survey NOT finished."),
    ExitStatus.REPLAY: Message("The replay has ended."),
    ExitStatus.PAUSED: Message("Survey PAUSED; it stays paused."),
    ExitStatus.STOPPED: Message("Survey stopped."),
}
_UNSUCCESSFUL = (ExitStatus.REFUSED, ExitStatus.FAILED, ExitStatus.PAUSED)
_LINK_DOWN = Message(
    "No contact with the main control. The robot may still move. Waiting for the link."
)
_LINK_BACK = Message("In contact with the main control again.")
_END_HINT = Message("End it with `rosservice call stop_survey` in the robot's namespace.")
_RESUME_HINT = Message(
    "Resume it with `rosrun gpr20_user_interface run_survey --resume`, or end it with `rosservice "
    "call stop_survey` in the robot's namespace."
)


class ReplayFollower:
    """Takes events and gives in the end an outcome."""

    def __init__(self) -> None:
        self.outcome: Optional[Outcome] = None
        self._model = ReplayModel()

    @property
    def survey_id(self) -> str:
        """The recorded survey; empty while it is not known."""
        return self._model.survey_id

    def concerns(self, event: object) -> bool:
        """Return whether an event is to be shown."""
        return not isinstance(event, StopRequested)

    def handle(self, event: object) -> List[Request]:
        """Take an event; there is never a request to send."""
        self._model.handle(event)
        shown = self._model.snapshot()
        if isinstance(event, StopRequested):
            message = Message("The replay is no longer followed.")
            self.outcome = Outcome(ExitStatus.STOPPED, message)
        elif shown.replay is not None and shown.replay.ended:
            self.outcome = Outcome(ExitStatus.REPLAY, _replay_end(shown.state))
        return []

    def tick(self) -> List[Request]:
        """Nothing is due: a replay may pause for any time."""
        return []


def _replay_end(state: Optional[ControlState]) -> Message:
    if state is None or state.code not in ENDED:
        return Message("The recording does not contain the survey's end.")
    return Message(
        "The recorded survey ended {state}: {message}",
        state=state.code.label,
        message=state.message,
    )


Follower = Union[SurveyFollower, ReplayFollower]


class SurveySession:
    """Carries events to the follower and the display, and requests to the main control.

    Attributes:
        simulated: Whether the robot is simulated.
        stored: Whether a trace of the survey is stored, so that it can be resumed.
    """

    def __init__(
        self,
        follower: Follower,
        events: queue.SimpleQueue,
        send: Callable[[Request], None],
        display: PlainDisplay,
    ) -> None:
        self._follower = follower
        self._events = events
        self._send = send
        self._display = display
        self.simulated = False
        self._state: Optional[ControlState] = None
        self._step: Optional[Message] = None
        self._progress: Optional[Progress] = None
        self.stored = False

    def run(self, requests: Sequence[Request] = ()) -> Outcome:
        """Send requests, and return when the survey has ended: how it ended."""
        try:
            for request in requests:
                self._send(request)
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

    def _next_event(self) -> Optional[object]:
        try:
            return self._events.get(timeout=TICK_S)
        except queue.Empty:
            return None

    def _show_last_progress(self) -> None:
        """Show the last trace too: progress and end are different topics and come in any order."""
        for _ in range(LAST_EVENTS):
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
        self._display.note(Message("{state}: {message}", state=state.title, message=state.message))
        message = state.message
        # The same warning with another number needs no other step.
        step = first_step(message) if state.is_fault or _asks(message) else None
        if step is not None and step != self._step:
            self._display.note(step)
        self._step = step
        if self._progress is not None:
            self._display.show(self._progress, state)

    def _show(self, event: object) -> None:
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
            self._display.note(_accepted(event))
        elif isinstance(event, LinkState):
            self._display.note(_LINK_DOWN if event.down else _LINK_BACK)
        elif isinstance(event, StopRequested):
            self._display.note(Message("{signal}: stopping the survey.", signal=event.signal))
        elif isinstance(event, Answer) and event.request is Request.STOP and not event.success:
            self._display.note(Message("Stop not accepted: {reason}", reason=event.message))


def _accepted(plan: Accepted) -> Message:
    return Message(
        "Parameters accepted: {traces} traces, estimated time: {time}.",
        traces=plan.total_points,
        time=duration(plan.estimated_s),
    )


def _asks(message: Message) -> bool:
    warns = message.severity not in (None, Severity.NOTE)
    return message.may_move or (warns and message.remedy is not None)


def first_step(message: Message) -> Message:
    """Return what to do first about a fault, with its code."""
    code = message.fault_code
    return Message("Do this first: {remedy}", remedy=remedy(message), details=code)


def outcome_lines(
    outcome: Outcome, survey_id: str, simulated: bool, stored: bool = False
) -> List[Message]:
    """Return the last lines of the client; stored: whether a trace of the survey is."""
    message = outcome.message
    lines = [_HEADLINES[outcome.status], message]
    unknown = outcome.status in _UNSUCCESSFUL and not message.fault_code
    refused = outcome.status is ExitStatus.REFUSED or message.may_move
    if unknown or refused or message.severity is Severity.FAULT:
        lines.append(first_step(message))
    if survey_id:
        lines.append(Message("Survey id: {survey}", survey=survey_id))
    if outcome.other_analyzer:
        lines.append(
            Message(
                "To continue with this VNA, resume with `--accept-analyzer {identity}`.",
                identity=shlex.quote(outcome.other_analyzer),
            )
        )
    if message.fault_code == OTHER_ZEROS.code:
        lines.append(
            Message("To continue as it is, resume with `--accept-zeros`; its traces are marked.")
        )
    can_continue = message.can_continue
    if outcome.status is ExitStatus.PAUSED:
        lines.append(_RESUME_HINT if can_continue else _END_HINT)
    elif outcome.status in (ExitStatus.STOPPED, ExitStatus.FAILED) and stored and can_continue:
        lines.append(
            Message(
                "Measure the missing traces, while no other survey runs, with `rosrun "
                "gpr20_user_interface run_survey --resume {survey}`.",
                survey=survey_id,
            )
        )
    if simulated:
        lines.append(SIMULATED)
    return lines
