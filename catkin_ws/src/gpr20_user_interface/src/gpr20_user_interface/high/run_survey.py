"""The terminal client: run a survey without a window."""

from __future__ import annotations

import queue
import sys
from typing import Callable, Dict

import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.clock import Clock
from gpr20_survey.plan.survey_parameters import RobotTravel, problems
from gpr20_user_interface.errors import MasterUnavailableError, ParametersRefusedError
from gpr20_user_interface.high.control_client import ControlClient
from gpr20_user_interface.high.master import join_graph
from gpr20_user_interface.high.robot_travel import read_axis_limits
from gpr20_user_interface.low.stop_signals import SecondStopSignal, StopSignals, leave_now
from gpr20_user_interface.low.terminal_bar import TerminalBar
from gpr20_user_interface.mid.displays import BarDisplay, Display, PlainDisplay
from gpr20_user_interface.mid.events import DOCUMENTED_TRAVEL, Request, StopRequested
from gpr20_user_interface.mid.survey_arguments import Bar, Options, parse_arguments
from gpr20_user_interface.mid.survey_follower import ExitStatus, Limits, Mode, SurveyFollower
from gpr20_user_interface.mid.survey_session import SurveySession, outcome_lines


def main() -> int:
    """Run a survey as the command line says; return the exit status."""
    options = parse_arguments(rospy.myargv()[1:])
    # Unlike that of queue.Queue its put() may be interrupted by a signal that puts, too.
    events: queue.SimpleQueue = queue.SimpleQueue()
    try:
        with StopSignals(lambda name: events.put(StopRequested(name))) as signals:
            return _run(options, events, signals)
    except SecondStopSignal:
        print("\nleft at once, without waiting: the robot may still run", file=sys.stderr)
        leave_now(ExitStatus.STOPPED)


def _run(options: Options, events: queue.SimpleQueue, signals: StopSignals) -> int:
    try:
        # What can be refused at once needs no robot.
        _check(options, DOCUMENTED_TRAVEL)
        join_graph("run_survey", options.wait_s, lambda: signals.received, Clock())
        _check(options, read_axis_limits().travel or DOCUMENTED_TRAVEL)
    except Gpr20Error as error:
        print(f"run_survey: {error}", file=sys.stderr)
        status = ExitStatus.STOPPED if signals.received else ExitStatus.REFUSED
        if isinstance(error, MasterUnavailableError):
            # Nobody to take leave of; rospy would wait for the master once more.
            leave_now(status)
        return status
    return _follow(options, events)


def _check(options: Options, travel: RobotTravel) -> None:
    found = problems(options.parameters, travel) if options.mode is Mode.START else []
    if found:
        raise ParametersRefusedError("refused: " + "; ".join(found))


def _follow(options: Options, events: queue.SimpleQueue) -> int:
    client = ControlClient(events.put)
    requests: Dict[Request, Callable[[], None]] = {
        Request.START: lambda: client.start_survey(options.parameters),
        Request.STOP: client.stop_survey,
        Request.RESUME: lambda: client.resume_survey(options.resume_id),
    }
    limits = Limits(wait_s=options.wait_s)
    follower = SurveyFollower(options.mode, options.on_pause, limits, Clock())
    session = SurveySession(
        follower, events, lambda request: requests[request](), _display(options.bar)
    )
    client.listen()
    outcome = session.run()
    client.close()
    lines = outcome_lines(outcome, follower.survey_id, session.simulated, session.stored)
    is_error = outcome.status in (ExitStatus.REFUSED, ExitStatus.FAILED)
    print("\n".join(lines), file=sys.stderr if is_error else sys.stdout, flush=True)
    return outcome.status


def _display(bar: Bar) -> Display:
    wanted = sys.stdout.isatty() if bar is Bar.AUTO else bar is Bar.ALWAYS
    return BarDisplay(TerminalBar(sys.stdout)) if wanted else PlainDisplay(sys.stdout)
