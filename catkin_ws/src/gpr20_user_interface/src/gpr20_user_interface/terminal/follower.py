"""One survey in a terminal: asked for, followed by the status of the main control, and ended."""

from __future__ import annotations

import enum
import math
import queue
import shlex
import shutil
from dataclasses import dataclass
from typing import Callable, List, Optional, TextIO

from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import MAY_MOVE, NOT_RUNNING, PART_LOST
from gpr20_common.low.clock import Clock
from gpr20_common.message import BETWEEN_SENTENCES, Message, Severity
from gpr20_common.terminal_text import printable
from gpr20_operator import faults
from gpr20_operator.robot.events import (
    Accepted,
    Answer,
    ControlState,
    Progress,
    Request,
    SenderIgnored,
    StopRequested,
)
from gpr20_operator.robot.notices import remedy
from gpr20_operator.robot.snapshot import remaining
from gpr20_operator.words import duration
from gpr20_survey.faults import NONE_OPEN, OTHER_ZEROS
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

TICK_S = 0.2
# The main control reports twice a second. So many ticks without a word: it is said, and later the
# client ends. Ticks, not times: a client that was suspended itself has heard nothing.
SAID_TICKS, LOST_TICKS = 25, 175
# A STOP is repeated as long as the client runs: the survey continues when the link is back.
LOST_STOP_TICKS = 4500
# For the first status of the survey that was accepted [s].
BEGIN_S = 10.0
# For axes to ramp down, a sweep to end and pending traces to be stored [s].
STOP_S = 60.0
# A line is written for each such part of the survey.
STEP_PERCENT = 10.0
SIMULATED = Message("SIMULATED robot: these data show no real ground.")


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
class Outcome:
    """How it ended.

    Attributes:
        other_analyzer: Identity of another analyzer with which the survey can be resumed; empty
            if there is nothing to accept.
    """

    status: ExitStatus
    message: Message
    other_analyzer: str = ""


class Display:
    """Sentences and progress; on a terminal the last line is written again for each trace."""

    def __init__(self, stream: TextIO, catalogue: Catalogue) -> None:
        self._stream, self._catalogue = stream, catalogue
        self._next_percent = 0.0
        # Whether the line of progress is still open.
        self._open = False

    def note(self, message: Message) -> None:
        """Write a sentence, with its details in brackets."""
        details = BETWEEN_SENTENCES.join(message.all_details)
        sentence = self._catalogue.text(message)
        self.close()
        self._write(printable(f"{sentence} ({details})" if details else sentence) + "\n")

    def close(self) -> None:
        """End the line of progress."""
        if self._open:
            self._write("\n")
            self._open = False

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
            self._write(f"\r{text}\x1b[K")
            self._open = True
        elif progress.completion_percent >= self._next_percent:
            after = min(progress.completion_percent + STEP_PERCENT, 100.0)
            self._next_percent = math.inf if progress.is_complete else after
            self.note(line)

    def _write(self, text: str) -> None:
        self._stream.write(text)
        # So that the reader of a pipe sees it when it happens.
        self._stream.flush()


class SurveyFollower:
    """Takes events and ticks until there is an outcome.

    Args:
        ask: Asks for the survey; None: the one that runs is followed.
        stop: Asks whatever moves to stop, again and again until it answers.
        display: Shows what happens.
        wait_s: For the first status of the main control [s].

    Attributes:
        outcome: How it ended; None: it has not.
        survey_id: Empty while it is not known.
    """

    def __init__(
        self,
        ask: Optional[Callable[[], None]],
        stop: Callable[[], None],
        display: Display,
        wait_s: float,
        clock: Clock,
    ) -> None:
        self._ask, self._stop, self._display = ask, stop, display
        self._wait_s, self._now_s = wait_s, clock.now_s
        self.outcome: Optional[Outcome] = None
        self.survey_id = ""
        self._simulated = self._stored = self._replay = False
        # When the first status came, and the answer; when STOP was asked for [s].
        self._since_s = self._now_s()
        self._asked = self._answered = False
        self._stopping_s: Optional[float] = None
        self._stop_refused = False
        # Whether a status is about our survey; the last one that is.
        self._begun = False
        self._state: Optional[ControlState] = None
        self._step: Optional[Message] = None
        self._quiet_ticks = 0

    def run(self, events: queue.SimpleQueue) -> Outcome:
        """Take events until the survey has ended; return how."""
        while self.outcome is None:
            try:
                self.take(events.get(timeout=TICK_S))
            except queue.Empty:
                self.tick()
        return self.outcome

    def take(self, event: object) -> None:
        """Take an event."""
        if isinstance(event, ControlState):
            self._quiet_ticks = 0
            self._take_state(event)
        elif isinstance(event, Progress):
            self._quiet_ticks = 0
            if self._begun and event.survey_id == self.survey_id:
                self._stored = event.visited_points > 0
                self._display.show(event)
        elif isinstance(event, Accepted):
            self._display.note(
                Message(
                    "Parameters accepted: {traces} traces, estimated time: {time}.",
                    traces=event.total_points,
                    time=duration(event.estimated_s),
                )
            )
        elif isinstance(event, Answer):
            self._take_answer(event)
        elif isinstance(event, StopRequested):
            self._take_stop(event)
        elif isinstance(event, SenderIgnored):
            self._replay = True

    def tick(self) -> None:
        """Note that nothing has come for `TICK_S`."""
        self._quiet_ticks += 1
        now_s, stopping_s = self._now_s(), self._stopping_s
        lost_ticks = LOST_TICKS if stopping_s is None else LOST_STOP_TICKS
        if not self._asked:
            if now_s - self._since_s > self._wait_s:
                self._end(ExitStatus.REFUSED, self._nobody())
        elif self._quiet_ticks == SAID_TICKS:
            self._display.note(
                Message(
                    "No contact with the main control. The robot may still move. Waiting for it."
                )
            )
        elif self._quiet_ticks > lost_ticks:
            self._end(ExitStatus.FAILED, _lost(lost_ticks * TICK_S))
        elif (
            stopping_s is not None
            and now_s - stopping_s > STOP_S
            and self._quiet_ticks < SAID_TICKS
        ):
            message = Message(
                "The main control did not confirm within {limit_s:g} s that the survey has "
                "stopped. The robot may still move: switch it off if people are near it.",
                limit_s=STOP_S,
            )
            self._end(ExitStatus.FAILED, message.with_fault(MAY_MOVE))

    def _nobody(self) -> Message:
        if self._replay:
            return Message(
                "A replay of a recorded survey is running here, and no robot. To use a robot, end "
                "the replay and start the robot."
            ).with_fault(faults.REPLAY)
        return Message(
            "No contact with the main control within {limit_s:g} s. Start it with `roslaunch gpr20 "
            "survey.launch`. If it is running, check ROS_MASTER_URI and the namespace.",
            limit_s=self._wait_s,
        ).with_fault(NOT_RUNNING)

    def _take_state(self, state: ControlState) -> None:
        if state.simulated and not self._simulated:
            self._simulated = True
            self._display.note(SIMULATED)
        if not self._asked:
            self._take_first_state(state)
            return
        if self._stop_refused:  # it may have come before there was anything to stop
            self._stop_refused = False
            self._stop()
        own = bool(self.survey_id) and state.survey_id == self.survey_id
        if not self._begun:
            # What stands still now is from before the request.
            self._begun = own or (state.code in RUNNING and state.code is not SurveyState.PAUSED)
        if self._begun and (own or not self.survey_id):
            self._show(state)
            self._state = state
            self._follow()
        elif self._answered and (self._begun or self._now_s() - self._since_s > BEGIN_S):
            self._end(ExitStatus.FAILED, self._replaced(state))

    def _take_first_state(self, state: ControlState) -> None:
        self._asked, self._since_s = True, self._now_s()
        if self._ask is not None:
            self._ask()
        elif state.code in RUNNING:
            self.survey_id, self._answered = state.survey_id, True
            self._take_state(state)
        else:
            message = Message(
                "No survey is running. The main control is {state}: {message}",
                state=state.code.label,
                message=state.message,
            )
            self._end(ExitStatus.REFUSED, message.reporting_only(NONE_OPEN))

    def _take_answer(self, answer: Answer) -> None:
        stopping = self._stopping_s is not None
        if answer.request is Request.STOP:
            self._stop_refused = not answer.success
            if not answer.success:
                self._display.note(Message("Stop not accepted: {reason}", reason=answer.message))
        elif answer.success:
            self._answered, self._since_s = True, self._now_s()
            # The id of a resumed survey comes with its status.
            self.survey_id = answer.survey_id
            if stopping:
                self._stop()
            self._follow()
        elif stopping:
            message = Message("The survey was not started: {reason}", reason=answer.message)
            self._end(ExitStatus.STOPPED, message)
        else:
            self.outcome = Outcome(ExitStatus.REFUSED, answer.message, answer.other_analyzer)

    def _take_stop(self, event: StopRequested) -> None:
        if not self._asked:
            self._end(ExitStatus.STOPPED, Message("Nothing was started."))
            return
        self._display.note(Message("{signal}: stopping the survey.", signal=event.signal))
        self._stopping_s = self._now_s()
        self._stop()

    def _follow(self) -> None:
        """End with the survey."""
        state = self._state
        if state is None or not self._answered:
            return
        self.survey_id = state.survey_id
        stopping = self._stopping_s is not None
        said = state.message if state.code is state.shown else state.title
        if state.shown is SurveyState.FINISHED:
            self._end(ExitStatus.FINISHED, said)
        elif state.shown in ENDED:
            asked = stopping and state.shown is SurveyState.STOPPED
            self._end(ExitStatus.STOPPED if asked else ExitStatus.FAILED, said)
        elif state.code is SurveyState.PAUSED and not stopping:
            self._end(ExitStatus.PAUSED, state.message)

    def _show(self, state: ControlState) -> None:
        if state == self._state:
            return
        message = state.message
        self._display.note(Message("{state}: {message}", state=state.title, message=message))
        warns = message.severity not in (None, Severity.NOTE) and message.remedy is not None
        # The same warning with another number needs no other step.
        step = first_step(message) if state.is_fault or message.may_move or warns else None
        if step is not None and step != self._step:
            self._display.note(step)
        self._step = step

    def _replaced(self, state: ControlState) -> Message:
        return Message(
            "The main control no longer knows survey {survey}; it may have been restarted. The "
            "traces measured so far are in the survey's folder. The main control is {state}: "
            "{message}",
            survey=self.survey_id,
            state=state.code.label,
            message=state.message,
        ).reporting_only(PART_LOST)

    def _end(self, status: ExitStatus, message: Message) -> None:
        self.outcome = Outcome(status, message)

    def last_words(self) -> List[Message]:
        """Return what is said of the outcome, and how to continue."""
        outcome = self.outcome
        assert outcome is not None
        status, message = outcome.status, outcome.message
        lines = [_HEADLINES[status], message]
        unknown = status in (ExitStatus.FAILED, ExitStatus.PAUSED) and not message.fault_code
        refused = status is ExitStatus.REFUSED or message.may_move
        if unknown or refused or message.severity is Severity.FAULT:
            lines.append(first_step(message))
        if self.survey_id:
            lines.append(Message("Survey id: {survey}", survey=self.survey_id))
        if outcome.other_analyzer:
            lines.append(
                Message(
                    "To continue with this VNA, resume with `--accept-analyzer {identity}`.",
                    identity=shlex.quote(outcome.other_analyzer),
                )
            )
        if message.fault_code == OTHER_ZEROS.code:
            lines.append(
                Message(
                    "To continue as it is, resume with `--accept-zeros`; its traces are marked."
                )
            )
        ended_early = self._stored and status in (ExitStatus.STOPPED, ExitStatus.FAILED)
        if message.can_continue and (ended_early or status is ExitStatus.PAUSED):
            lines.append(
                Message(
                    "Measure the missing traces, while no other survey runs, with `rosrun "
                    "gpr20_user_interface run_survey --resume {survey}`.",
                    survey=self.survey_id,
                )
            )
        elif status is ExitStatus.PAUSED:
            lines.append(
                Message("End it with `rosservice call stop_survey` in the robot's namespace.")
            )
        return lines


def first_step(message: Message) -> Message:
    """Return what to do first about a fault, with its code."""
    code = message.fault_code
    return Message("Do this first: {remedy}", remedy=remedy(message), details=code)


def _lost(limit_s: float) -> Message:
    return Message(
        "No contact with the main control for {limit_s:g} s. The robot may still move. Check "
        "that the main control is running, then follow the survey again with `rosrun "
        "gpr20_user_interface run_survey --attach`.",
        limit_s=limit_s,
    ).with_fault(PART_LOST)
