"""One survey in a terminal: asked for, followed by what is known of the robot, and ended."""

from __future__ import annotations

import enum
import math
import queue
import shutil
from dataclasses import dataclass
from typing import Callable, List, Optional, Sequence, TextIO

from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import MAY_MOVE
from gpr20_common.low.clock import Clock
from gpr20_common.message import BETWEEN_SENTENCES, Message, verbatim
from gpr20_common.terminal_text import printable
from gpr20_operator.robot.condition import condition_of
from gpr20_operator.robot.events import Answer, ControlState, Progress, Request
from gpr20_operator.robot.notices import remedy
from gpr20_operator.robot.snapshot import Snapshot, SurveyModel, remaining
from gpr20_survey.faults import NONE_OPEN
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

TICK_S = 0.2
# After this silence of the main control the client ends; a STOP is repeated for longer [s].
LOST_S, LOST_STOP_S = 35.0, 900.0
# For the end of a survey after a STOP [s].
STOP_S = 60.0
# In a file or a pipe a line is written for each such part of the survey.
STEP_PERCENT = 10.0


class ExitStatus(enum.IntEnum):
    """How the survey ended, as the status of the process."""

    FINISHED = 0
    REFUSED = 1
    FAILED = 3
    PAUSED = 4
    STOPPED = 130


_HEADLINES = {
    ExitStatus.FINISHED: Message("Survey finished."),
    ExitStatus.REFUSED: Message("No survey was run."),
    ExitStatus.FAILED: Message("Survey NOT finished."),
    ExitStatus.PAUSED: Message("Survey PAUSED; it stays paused."),
    ExitStatus.STOPPED: Message("Survey stopped."),
}


@dataclass(frozen=True)
class StopRequested:
    """The operator wants to stop the survey; `signal` is the name of the key or signal."""

    signal: str


class Display:
    """Sentences and progress; on a terminal the last line is written again for each trace."""

    def __init__(self, stream: TextIO, catalogue: Catalogue) -> None:
        self._stream, self._catalogue = stream, catalogue
        self._next_percent = 0.0
        # What ends the line of progress that is still open.
        self._end = ""

    def note(self, message: Message) -> None:
        """Write a sentence, with its details in brackets."""
        details = BETWEEN_SENTENCES.join(message.all_details)
        sentence = self._catalogue.text(message)
        line = printable(f"{sentence} ({details})" if details else sentence)
        self._write(f"{self._end}{line}\n", "")

    def show(self, progress: Progress) -> None:
        """Show how far the survey is."""
        line = Message(
            "{percent:5.1f} %  {visited}/{total} traces  {remaining}",
            percent=progress.completion_percent,
            visited=progress.visited_points,
            total=progress.total_points,
            remaining=remaining(progress),
        )
        if self._stream.isatty():
            # To the end of the line: the one before may have been longer.
            text = printable(self._catalogue.text(line))[: shutil.get_terminal_size().columns - 1]
            self._write(f"\r{text}\x1b[K", "\n")
        elif progress.completion_percent >= self._next_percent:
            after = min(progress.completion_percent + STEP_PERCENT, 100.0)
            self._next_percent = math.inf if progress.is_complete else after
            self.note(line)

    def close(self) -> None:
        """End the line of progress."""
        self._write(self._end, "")

    def _write(self, text: str, end: str) -> None:
        self._stream.write(text)
        self._end = end
        # So that the reader of a pipe sees it when it happens.
        self._stream.flush()


class SurveyFollower:
    """Takes events until the survey has ended.

    Args:
        ask: Asks for the survey.
        stop: Asks whatever moves to stop.
        display: Shows what happens.
        wait_s: For the first status of the main control [s].

    Attributes:
        status: How it ended; None: it has not.
        message: Why.
        survey_id: Empty while it is not known.
    """

    def __init__(
        self,
        ask: Callable[[], None],
        stop: Callable[[], None],
        display: Display,
        wait_s: float,
        clock: Clock,
    ) -> None:
        self._ask, self._stop, self._display = ask, stop, display
        self._wait_s, self._now_s = wait_s, clock.now_s
        self._model = SurveyModel(clock)
        self.status: Optional[ExitStatus] = None
        self.message, self.survey_id = verbatim(""), ""
        self._asked = self._answered = False
        self._looked_s, self._silent_s, self._stopping_s = self._now_s(), 0.0, math.inf
        self._said: object = None

    def run(self, events: queue.SimpleQueue) -> ExitStatus:
        """Take events until the survey has ended; return how."""
        while self.status is None:
            try:
                self.take(events.get(timeout=TICK_S))
            except queue.Empty:
                self.look()
        return self.status

    def take(self, event: object) -> None:
        """Take an event."""
        self._model.handle(event)
        if isinstance(event, ControlState) and self._asked:
            self._take_state(event)
        elif isinstance(event, Answer):
            self._take_answer(event)
        elif isinstance(event, StopRequested):
            self._take_stop(event)
        self.look()
        if isinstance(event, Progress) and self._asked and event.survey_id == self.survey_id:
            self._display.show(event)

    def look(self) -> None:
        """Look at the clock and at what is known now."""
        snapshot, now_s = self._model.snapshot(), self._now_s()
        # A client that was suspended itself has heard nothing: that is no silence.
        step_s, self._looked_s = min(now_s - self._looked_s, TICK_S), now_s
        self._silent_s = 0.0 if snapshot.control_alive else self._silent_s + step_s
        if self.status is not None:
            return
        if self._asked:
            self._follow(snapshot)
        elif snapshot.state is not None:
            self._asked = True
            if snapshot.simulated:
                self._display.note(Message("SIMULATED robot: these data show no real ground."))
            self._ask()
        elif self._silent_s > self._wait_s:
            self._end(ExitStatus.REFUSED, condition_of(snapshot).message)

    def _take_state(self, state: ControlState) -> None:
        # What stands still is from before the request.
        if state.code not in RUNNING - {SurveyState.PAUSED}:
            return
        self.survey_id = self.survey_id or state.survey_id
        if self._stopping_s < math.inf and state.code is not SurveyState.STOPPING:
            # STOP may have come before there was anything to stop.
            self._stop()

    def _take_answer(self, answer: Answer) -> None:
        if answer.request is Request.STOP:
            if not answer.success:
                self._display.note(Message("Stop not accepted: {reason}", reason=answer.message))
        elif answer.success:
            self._answered = True
            # The id of a resumed survey comes with its status.
            self.survey_id = answer.survey_id or self.survey_id
        else:
            stopped = self._stopping_s < math.inf
            self._end(ExitStatus.STOPPED if stopped else ExitStatus.REFUSED, answer.message)

    def _take_stop(self, event: StopRequested) -> None:
        if not self._asked:
            self._end(ExitStatus.STOPPED, Message("Nothing was started."))
            return
        self._display.note(Message("{signal}: stopping the survey.", signal=event.signal))
        self._stopping_s = self._now_s()
        self._stop()

    def _follow(self, snapshot: Snapshot) -> None:
        state, alive = snapshot.state, snapshot.control_alive
        stopping_s = self._now_s() - self._stopping_s
        own = state is not None and bool(self.survey_id) and state.survey_id == self.survey_id
        lost = self._silent_s > (LOST_S if stopping_s < 0.0 else LOST_STOP_S)
        if own or not alive:
            self._show(snapshot)
        if lost or (alive and snapshot.interrupted and self._answered):
            self._end(ExitStatus.FAILED, condition_of(snapshot).message)
        elif alive and stopping_s > STOP_S:
            message = Message(
                "The main control did not confirm within {limit_s:g} s that the survey has "
                "stopped. The robot may still move: switch it off if people are near it.",
                limit_s=STOP_S,
            )
            self._end(ExitStatus.FAILED, message.with_fault(MAY_MOVE))
        elif state is not None and own and self._answered:
            self._end_with(state, stopping_s >= 0.0)

    def _end_with(self, state: ControlState, stopping: bool) -> None:
        said = state.message if state.code is state.shown else state.title
        if state.shown is SurveyState.FINISHED:
            self._end(ExitStatus.FINISHED, said)
        elif state.shown in ENDED:
            asked = stopping and state.shown is SurveyState.STOPPED
            self._end(ExitStatus.STOPPED if asked else ExitStatus.FAILED, said)
        elif state.code is SurveyState.PAUSED and not stopping:
            self._end(ExitStatus.PAUSED, state.message)

    def _show(self, snapshot: Snapshot) -> None:
        """Write the state and what to do first, whenever the state or its fault is another."""
        condition = condition_of(snapshot)
        known = snapshot.code, condition.level, condition.message.fault_code
        if known != self._said:
            self._said = known
            self._display.note(
                Message("{state}: {message}", state=condition.title, message=condition.message)
            )
            if condition.asked is not None:
                self._display.note(first_step(condition.message))

    def _end(self, status: ExitStatus, message: Message) -> None:
        self.status, self.message = status, message

    def last_words(self, resumable: Callable[[], Sequence[str]]) -> List[Message]:
        """Return what is said at the end, and how to continue.

        Args:
            resumable: Reads which surveys can be resumed, by their ids.
        """
        assert self.status is not None
        status, message = self.status, self.message
        lines, to_resume = [_HEADLINES[status], message], [self.survey_id]
        if status is ExitStatus.REFUSED:
            to_resume = list(resumable()) if message.fault_code == NONE_OPEN.code else []
        elif self.survey_id:
            lines.append(Message("Survey id: {survey}", survey=self.survey_id))
        if status is ExitStatus.FINISHED or not message.can_continue:
            to_resume = []
        if status not in (ExitStatus.FINISHED, ExitStatus.STOPPED) and not to_resume:
            lines.append(first_step(message))
        return lines + [
            Message(
                "Measure the missing traces, while no other survey runs, with `rosrun "
                "gpr20_user_interface run_survey --resume {survey}`.",
                survey=one,
            )
            for one in filter(None, to_resume)
        ]


def first_step(message: Message) -> Message:
    """Return what to do first about a fault, with its code."""
    code = message.fault_code
    return Message("Do this first: {remedy}", remedy=remedy(message), details=code)
