"""The terminal client: run a survey without a window."""

from __future__ import annotations

import dataclasses
import io
import os
import queue
import sys
from typing import Callable, Dict, Sequence

import rospy

from gpr20_common.catalogue import Catalogue, read_catalogue
from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.high.graph_keeper import GraphKeeper
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_operator.errors import MasterUnavailableError, ParametersRefusedError
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.high.master import LinkWatch, join_graph
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL, ControlState, Request, StopRequested
from gpr20_operator.robot.senders import SenderIgnored, Senders
from gpr20_survey.plan.survey_parameters import check
from gpr20_user_interface.low.process import SecondStopSignal, StopSignals, leave_now
from gpr20_user_interface.terminal.displays import (
    BarDisplay,
    PlainDisplay,
    is_confirmed,
    terminal_line,
)
from gpr20_user_interface.terminal.follower import ExitStatus, Limits, Mode, Outcome, SurveyFollower
from gpr20_user_interface.terminal.session import (
    Follower,
    ReplayFollower,
    SurveySession,
    first_step,
    outcome_lines,
)
from gpr20_user_interface.terminal.survey_arguments import (
    Bar,
    Options,
    parse_arguments,
    terminal_language,
)

POLL_S = 0.2
# A robot beside a replay reports itself within this time [s].
ROBOT_LIMIT_S = 2.0


def main() -> int:
    """Run a survey as the command line asks; return the exit status."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr: not every terminal has all
    arguments = rospy.myargv()[1:]
    catalogue = read_catalogue(terminal_language(arguments, os.environ))
    options = parse_arguments(arguments, catalogue)
    # Unlike that of queue.Queue its put() may be interrupted by a signal that puts, too.
    events: queue.SimpleQueue = queue.SimpleQueue()
    try:
        with StopSignals(lambda name: events.put(StopRequested(name))) as signals:
            return _run(options, events, signals, catalogue)
    except SecondStopSignal:
        left = catalogue.tr("Ended at once, without waiting: the robot may still move.")
        say("", left, file=sys.stderr)
        leave_now(ExitStatus.STOPPED)


def _run(
    options: Options, events: queue.SimpleQueue, signals: StopSignals, catalogue: Catalogue
) -> int:
    try:
        # What can be refused at once needs no robot.
        _check(options)
        join_graph("run_survey", options.wait_s, lambda: signals.received, Clock())
    except Gpr20Error as error:
        _print_refusal(error.message, catalogue)
        status = ExitStatus.STOPPED if signals.received else ExitStatus.REFUSED
        if isinstance(error, MasterUnavailableError):
            # At once: the exit handlers of rospy would wait for the master.
            leave_now(status)
        return status
    return _follow(options, events, signals, catalogue)


def _print_refusal(reason: Message, catalogue: Catalogue) -> None:
    lines = [terminal_line(one, catalogue) for one in (reason, first_step(reason))]
    say(f"run_survey: {lines[0]}", *lines[1:], file=sys.stderr)


def _check(options: Options) -> None:
    if options.mode is not Mode.START:
        return
    try:
        check(options.parameters, DOCUMENTED_TRAVEL)
    except InvalidValueError as error:
        raise ParametersRefusedError(Message("refused: {reason}", reason=error.message)) from error


def _follow(
    options: Options, events: queue.SimpleQueue, signals: StopSignals, catalogue: Catalogue
) -> int:
    robot = SurveyFollower(options.mode, options.on_pause, Limits(wait_s=options.wait_s), Clock())
    replay = options.mode is Mode.ATTACH and _is_replay(options.wait_s, signals, Clock())
    follower: Follower = ReplayFollower() if replay else robot
    client = ControlClient(events.put, Senders(rospy.get_namespace(), replay))
    client.listen()
    keeper, link = GraphKeeper(), LinkWatch(events.put)
    outcome = _run_session(options, client, follower, events, catalogue)
    if outcome.other_analyzer and _accepts(outcome.other_analyzer, signals, catalogue):
        options = dataclasses.replace(options, accept_analyzer=outcome.other_analyzer)
        outcome = _run_session(options, client, robot, events, catalogue, robot.ask_again())
    link.close()
    keeper.close()
    client.close()
    if outcome.other_analyzer and signals.received:
        return ExitStatus.STOPPED
    return outcome.status


def _is_replay(wait_s: float, signals: StopSignals, clock: Clock) -> bool:
    """Wait until somebody reports on a survey; return whether that is no robot."""
    heard: queue.SimpleQueue = queue.SimpleQueue()
    client = ControlClient(heard.put, Senders(rospy.get_namespace()))
    client.listen()
    deadline_s, ignored = clock.now_s() + wait_s, False
    try:
        while not signals.received and clock.now_s() < deadline_s:
            try:
                event = heard.get(timeout=POLL_S)
            except queue.Empty:
                continue
            if isinstance(event, ControlState):
                return False
            if isinstance(event, SenderIgnored) and not ignored:
                ignored, deadline_s = True, clock.now_s() + ROBOT_LIMIT_S
    finally:
        client.close()
    return ignored


def _run_session(
    options: Options,
    client: ControlClient,
    follower: Follower,
    events: queue.SimpleQueue,
    catalogue: Catalogue,
    first: Sequence[Request] = (),
) -> Outcome:
    """Follow a survey to its end, and print how it ended."""
    requests: Dict[Request, Callable[[], None]] = {
        Request.START: lambda: client.start_survey(
            options.parameters, options.annotation, permittivity=options.permittivity
        ),
        Request.STOP: client.stop,
        Request.RESUME: lambda: client.resume_survey(
            options.resume_id, options.accept_analyzer, options.accept_zeros
        ),
    }
    bar = sys.stdout.isatty() if options.bar is Bar.AUTO else options.bar is Bar.ALWAYS
    display = BarDisplay(sys.stdout, catalogue) if bar else PlainDisplay(sys.stdout, catalogue)
    session = SurveySession(follower, events, lambda request: requests[request](), display)
    outcome = session.run(first)
    messages = outcome_lines(outcome, follower.survey_id, session.simulated, session.stored)
    lines = [terminal_line(message, catalogue) for message in messages]
    is_error = outcome.status in (ExitStatus.REFUSED, ExitStatus.FAILED)
    say(*lines, file=sys.stderr if is_error else sys.stdout, flush=True)
    return outcome


def _accepts(analyzer: str, signals: StopSignals, catalogue: Catalogue) -> bool:
    """Ask whether the survey is continued with another analyzer, if somebody can answer."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        return False
    question = catalogue.tr("Continue with the VNA {identity}? [y/N]", identity=analyzer)
    return is_confirmed(question, lambda: signals.received)
