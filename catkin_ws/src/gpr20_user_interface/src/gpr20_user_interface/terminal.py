"""The terminal client without ROS: its command line, its lines, and a survey until it has ended."""

from __future__ import annotations

import argparse
import enum
import math
import queue
from dataclasses import dataclass, replace
from typing import Any, Callable, List, Optional, Sequence, TextIO

from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_common.message import BETWEEN_SENTENCES, Message, verbatim
from gpr20_common.mid.checks import number_between
from gpr20_common.terminal_text import printable
from gpr20_operator.plan.fields import (
    PARAMETERS,
    PEOPLE,
    SPECS,
    FieldSpec,
    Tile,
    default_parameters,
)
from gpr20_operator.robot.condition import Condition, condition_of, lost
from gpr20_operator.robot.events import (
    DOCUMENTED_TRAVEL,
    Answer,
    ControlState,
    Progress,
    Request,
    StartPlan,
    SurveyControl,
)
from gpr20_operator.robot.notices import remedy
from gpr20_operator.robot.snapshot import CONTROL_SILENCE_S, Snapshot, SurveyModel
from gpr20_operator.words import number_from_text, time_left
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.survey_parameters import check_output_power
from gpr20_survey.plan.survey_state import RUNNING, SurveyState

DESCRIPTION = Message(
    "Run a survey without a window: set its parameters, start it and follow it to its end.\n"
    "Ctrl-C stops the survey and waits for the confirmation of the main control."
)
EXIT_STATUS = Message(
    "exit status:\n"
    "    0  the survey finished: every planned trace is stored\n"
    "    1  it was refused or could not be started\n"
    "    2  the command line is wrong\n"
    "    3  it failed, another client stopped it, or contact with the main control was lost\n"
    "    4  it is paused and stays paused\n"
    "  130  it was stopped by Ctrl-C or SIGTERM; after a second one it may still run\n"
)
SOIL = SPECS["permittivity"]
# For the main control, and between two looks at the clock [s].
WAIT_S, MAX_WAIT_S, TICK_S = 15.0, 3600.0, 0.2
# The client ends after this silence of the main control; after a STOP, which it repeats until that
# is answered, it ends this much later at the latest [s].
LOST_S, STOP_S = 35.0, 900.0
# In a file or a pipe a line is written for each such part of the survey.
STEP_PERCENT = 10.0


@dataclass(frozen=True)
class Options:
    """What the command line asks for."""

    plan: StartPlan
    # The survey to resume, by id or folder; empty: the paused one; None: none.
    resume: Optional[str]
    # For the master, and for the first status of the main control [s].
    wait_s: float


def parse_arguments(arguments: Sequence[str], catalogue: Catalogue) -> Options:
    """Read the command line, without the name of the program and without ROS remappings.

    Raises:
        SystemExit: With status 2 after a message, or 0 after the help.
    """
    parser = _parser(catalogue)
    given = vars(parser.parse_args(arguments))
    resume, wait_s = given.pop("resume"), given.pop("wait")
    if resume is not None and given:
        options = ", ".join(option_of(SPECS[name]) for name in given)
        parser.error(
            catalogue.tr(
                "{options} cannot be given with --resume: that survey has its own", options=options
            )
        )
    # The window begins with a soil, which a person sees there; a command assumes none.
    permittivity = given.pop(SOIL.name, 0.0)
    people = {one.name: given.pop(one.name) for one in PEOPLE if one.name in given}
    parameters = replace(default_parameters(), **given)
    try:
        check_output_power(parameters.output_power)
    except InvalidValueError as error:
        parser.error(catalogue.text(error.message))
    plan = StartPlan(parameters, replace(EMPTY, **people), permittivity=permittivity)
    # Folders may be given with their path; the main control knows where they are.
    survey = None if resume is None else resume.rstrip("/").rsplit("/", 1)[-1]
    return Options(plan, survey, wait_s)


def _parser(catalogue: Catalogue) -> argparse.ArgumentParser:
    """Return the parser, whose result has only those fields of a plan that were given."""

    def reader(read: Callable[[str], Any]) -> Callable[[str], Any]:
        def read_argument(text: str) -> Any:
            try:
                return read(text)
            except InvalidValueError as error:
                # argparse shows the text of this error, but not that of a ValueError.
                raise argparse.ArgumentTypeError(catalogue.text(error.message)) from None

        return read_argument

    tr = catalogue.tr
    parser = argparse.ArgumentParser(
        prog="run_survey",
        description=catalogue.text(DESCRIPTION),
        epilog=catalogue.text(EXIT_STATUS),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    for spec in (*PARAMETERS, SOIL, *PEOPLE):
        parser.add_argument(
            option_of(spec),
            dest=spec.name,
            default=argparse.SUPPRESS,
            type=reader(spec.kind.read),
            metavar=spec.kind.metavar,
            # Percent signs are the formats of argparse.
            help=catalogue.text(_meaning(spec)).replace("%", "%%"),
        )
    resume = tr("resume the paused survey, or the one with this id or folder, and follow it")
    parser.add_argument("--resume", nargs="?", const="", metavar="SURVEY", help=resume)
    wait = tr("seconds to wait for the main control (default {default:g})", default=WAIT_S)
    read_wait = reader(lambda text: number_between("S", number_from_text(text), 0, MAX_WAIT_S, "s"))
    parser.add_argument("--wait", type=read_wait, default=WAIT_S, metavar="S", help=wait)
    return parser


def option_of(spec: FieldSpec) -> str:
    """Return the option for a field; frequencies are given in MHz."""
    return "--" + spec.name.replace("_frequency_hz", "_frequency_mhz").replace("_", "-")


def _meaning(spec: FieldSpec) -> Message:
    # How far the axes reach only the robot knows.
    unknown = spec.tile is Tile.AREA
    allowed = Message("within the axis") if unknown else spec.hint(DOCUMENTED_TRAVEL)
    meaning = Message("{field}: {allowed}", field=spec.title, allowed=allowed)
    if not spec.default or spec is SOIL:
        return meaning
    return Message("{meaning} (default {default})", meaning=meaning, default=spec.default)


class Display:
    """Sentences and progress; on a terminal the line of progress is written over itself."""

    def __init__(self, stream: TextIO, catalogue: Catalogue) -> None:
        self._stream, self._catalogue = stream, catalogue
        # Clears what a longer line of progress has left.
        self._clear = "\x1b[K" if stream.isatty() else ""
        self._step = -1.0

    def note(self, message: Message) -> None:
        """Write a sentence, with its details in brackets."""
        details = BETWEEN_SENTENCES.join(message.all_details)
        sentence = self._catalogue.text(message)
        self._write(f"{sentence} ({details})" if details else sentence, "\n")

    def show(self, progress: Progress) -> None:
        """Show how far the survey is; in a file or a pipe, at every tenth of it."""
        line = Message(
            "{percent:5.1f} %  {visited}/{total} traces  {remaining}",
            percent=progress.completion_percent,
            visited=progress.visited_points,
            total=progress.total_points,
            remaining=time_left(progress.remaining_s),
        )
        step = progress.completion_percent // STEP_PERCENT
        if self._clear or step > self._step:
            self._step = step
            self._write(self._catalogue.text(line), "\r" if self._clear else "\n")

    def _write(self, text: str, end: str) -> None:
        # So that the reader of a pipe sees it when it happens.
        print(f"{printable(text)}{self._clear}", end=end, file=self._stream, flush=True)


class ExitStatus(enum.IntEnum):
    """How the survey ended, as the status of the process."""

    FINISHED = 0
    REFUSED = 1
    FAILED = 3
    PAUSED = 4
    STOPPED = 130


_ENDS = {
    SurveyState.FINISHED: ExitStatus.FINISHED,
    SurveyState.PAUSED: ExitStatus.PAUSED,
    SurveyState.STOPPED: ExitStatus.FAILED,
    SurveyState.FAILED: ExitStatus.FAILED,
}
_ENDS_AFTER_STOP = {
    SurveyState.FINISHED: ExitStatus.FINISHED,
    SurveyState.STOPPED: ExitStatus.STOPPED,
    SurveyState.FAILED: ExitStatus.FAILED,
}


class SurveyFollower:
    """Asks for a survey, and takes events until it has ended; Request.STOP is the operator's wish.

    Attributes:
        status: How it ended; None: it has not.
        message: Why.
    """

    def __init__(
        self, options: Options, control: SurveyControl, display: Display, clock: Clock
    ) -> None:
        self._options, self._control, self._display = options, control, display
        self._model, self._now_s = SurveyModel(clock), clock.now_s
        self.status: Optional[ExitStatus] = None
        self.message = verbatim("")
        # Of the survey; empty while it is not known.
        self._id = ""
        self._asked = False
        self._answered_s = self._stopped_s = math.inf
        self._looked_s, self._silent_s = self._now_s(), 0.0
        self._said: object = None

    def run(self, events: queue.SimpleQueue) -> ExitStatus:
        """Take events until the survey has ended; return how."""
        while self.status is None:
            try:
                event = events.get(timeout=TICK_S)
            except queue.Empty:
                event = None
            self.take(event)
        return self.status

    def take(self, event: object) -> None:
        """Take an event, or None where none came; look at the clock and at what is known now."""
        refused = self._model.handle(event)
        if refused is not None:
            stopped = self._stopped_s < math.inf
            self._end(ExitStatus.STOPPED if stopped else ExitStatus.REFUSED, refused.message)
        elif event is Request.STOP:
            self._stop()
        elif isinstance(event, Answer) and event.request is not Request.STOP:
            # The id of a resumed survey comes with its status.
            self._answered_s, self._id = self._now_s(), event.survey_id or self._id
        elif isinstance(event, ControlState) and self._asked:
            self._note_begun(event)
        elif isinstance(event, Progress) and self._asked and event.survey_id == self._id:
            self._display.show(event)
        snapshot, now_s = self._model.state(), self._now_s()
        # A client that was suspended itself has heard nothing: that is no silence.
        step_s, self._looked_s = min(now_s - self._looked_s, TICK_S), now_s
        self._silent_s = 0.0 if snapshot.control_alive else self._silent_s + step_s
        if self.status is None and self._asked:
            self._follow(snapshot)
        elif self.status is None and snapshot.state is not None:
            self._ask(snapshot)
        elif self.status is None and self._silent_s > self._options.wait_s:
            self._end(ExitStatus.REFUSED, condition_of(snapshot).message)

    def last_words(self) -> List[Message]:
        """Return how it ended and why, and how to continue."""
        words = [self.message]
        if self._id and self.status is not ExitStatus.REFUSED:
            words.append(Message("Survey id: {survey}", survey=self._id))
            if self.status is not ExitStatus.FINISHED and self.message.can_continue:
                command = Message(
                    "Measure the missing traces, while no other survey runs, with `rosrun "
                    "gpr20_user_interface run_survey --resume {survey}`.",
                    survey=self._id,
                )
                return [*words, command]
        is_error = self.status not in (ExitStatus.FINISHED, ExitStatus.STOPPED)
        return [*words, first_step(self.message)] if is_error else words

    def _ask(self, snapshot: Snapshot) -> None:
        self._asked = True
        if snapshot.simulated:
            self._display.note(Message("SIMULATED robot: these data show no real ground."))
        if self._options.resume is None:
            self._control.start_survey(self._options.plan)
        else:
            self._control.resume_survey(self._options.resume)

    def _stop(self) -> None:
        if self._asked:
            self._display.note(Message("Stopping the survey."))
            self._stopped_s = self._now_s()
            self._control.stop()
        else:
            self._end(ExitStatus.STOPPED, Message("Nothing was started."))

    def _note_begun(self, state: ControlState) -> None:
        # What stands still is from before the request.
        if state.code in RUNNING - {SurveyState.PAUSED}:
            self._id = self._id or state.survey_id
            if self._stopped_s < math.inf and state.code is not SurveyState.STOPPING:
                # STOP may have come before there was anything to stop.
                self._control.stop()

    def _follow(self, snapshot: Snapshot) -> None:
        """End with the survey, or when nothing more can be known of it; else say what is new."""
        state, alive, condition = snapshot.state, snapshot.control_alive, condition_of(snapshot)
        now_s, stopping = self._now_s(), self._stopped_s < math.inf
        answered_s = now_s - self._answered_s
        own = state is not None and bool(self._id) and state.survey_id == self._id
        status = None
        if state is not None and own and answered_s >= 0.0:
            status = (_ENDS_AFTER_STOP if stopping else _ENDS).get(state.shown)
        if state is not None and status is not None:
            # After another plan was set the message is about that one.
            self._end(status, state.message if state.code is state.shown else state.shown.label)
        elif (self._silent_s > LOST_S and not stopping) or now_s - self._stopped_s > STOP_S:
            self._end(ExitStatus.FAILED, condition.message)
        elif alive and not own and answered_s > CONTROL_SILENCE_S:
            # It has accepted the survey and does not know it: it was restarted since.
            gone = lost(replace(snapshot, interrupted=True)) or condition
            self._end(ExitStatus.FAILED, gone.message)
        elif own or not alive:
            self._show(snapshot.code, condition)

    def _show(self, code: Optional[SurveyState], condition: Condition) -> None:
        """Write the state and what to do first, whenever the state or its fault is another."""
        known = code, condition.level, condition.message.fault_code
        if known != self._said:
            self._said = known
            self._display.note(
                Message("{state}: {message}", state=condition.title, message=condition.message)
            )
            if condition.asked is not None:
                self._display.note(first_step(condition.message))

    def _end(self, status: ExitStatus, message: Message) -> None:
        self.status, self.message = status, message


def first_step(message: Message) -> Message:
    """Return what to do first about a fault, with its code."""
    code = message.fault_code
    return Message("Do this first: {remedy}", remedy=remedy(message), details=code)
