"""The terminal client: run a survey without a window."""

from __future__ import annotations

import argparse
import io
import os
import queue
import sys

import rospy

from gpr20_common.catalogue import Catalogue, language_from_environment, read_catalogue
from gpr20_common.high.graph_keeper import GraphKeeper
from gpr20_common.low.clock import Clock
from gpr20_common.terminal_text import say
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.high.ros_events import join_graph
from gpr20_operator.robot.events import Senders, StopRequested
from gpr20_user_interface.low.process import SecondStopSignal, StopSignals, leave_now
from gpr20_user_interface.terminal.follower import Display, ExitStatus, SurveyFollower, first_step
from gpr20_user_interface.terminal.survey_arguments import parse_arguments


def main() -> int:
    """Run a survey as the command line asks; return the exit status."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr: not every terminal has all
    catalogue = read_catalogue(language_from_environment(os.environ))
    options = parse_arguments(rospy.myargv()[1:], catalogue)
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
    options: argparse.Namespace,
    events: queue.SimpleQueue,
    signals: StopSignals,
    catalogue: Catalogue,
) -> int:
    try:
        join_graph("run_survey", options.wait, lambda: signals.received, Clock())
    except MasterUnavailableError as error:
        display = Display(sys.stderr, catalogue)
        for message in (error.message, first_step(error.message)):
            display.note(message)
        # At once: the exit handlers of rospy would wait for the master.
        leave_now(ExitStatus.STOPPED if signals.received else ExitStatus.REFUSED)
    client = ControlClient(events.put, Senders(rospy.get_namespace()))

    def ask() -> None:
        if options.resume is not None:
            client.resume_survey(options.resume)
        else:
            client.start_survey(
                options.parameters, options.annotation, permittivity=options.permittivity
            )

    display = Display(sys.stdout, catalogue)
    follower = SurveyFollower(ask, client.stop, display, options.wait, Clock())
    client.listen()
    client.set_watched(True)
    keeper = GraphKeeper()
    status = follower.run(events)
    display.close()
    is_error = status in (ExitStatus.REFUSED, ExitStatus.FAILED)
    last = Display(sys.stderr if is_error else sys.stdout, catalogue)
    for message in follower.last_words():
        last.note(message)
    keeper.close()
    client.close()
    return status
