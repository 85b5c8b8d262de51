"""The terminal client: run a survey without a window."""

from __future__ import annotations

import io
import logging
import os
import queue
import sys

import rospy

from gpr20_common.catalogue import language_from_environment, read_catalogue
from gpr20_common.high.graph_keeper import GraphKeeper
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.high.ros_events import join_graph
from gpr20_operator.robot.events import Request, Senders
from gpr20_user_interface.low.process import StopSignals, leave_now
from gpr20_user_interface.terminal import (
    Display,
    ExitStatus,
    SurveyFollower,
    first_step,
    parse_arguments,
)


def main() -> int:
    """Run a survey as the command line asks; return the exit status."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr: not every terminal has all
    catalogue = read_catalogue(language_from_environment(os.environ))
    options = parse_arguments(rospy.myargv()[1:], catalogue)
    shown, failed = Display(sys.stdout, catalogue), Display(sys.stderr, catalogue)
    # Unlike that of queue.Queue its put() may be interrupted by a signal that puts, too.
    events: queue.SimpleQueue = queue.SimpleQueue()

    def leave() -> None:
        failed.note(Message("Ended at once, without waiting: the robot may still move."))
        leave_now(ExitStatus.STOPPED)

    with StopSignals(lambda: events.put(Request.STOP), leave) as signals:
        try:
            join_graph("run_survey", options.wait_s, lambda: signals.received, Clock())
        except MasterUnavailableError as error:
            for message in (error.message, first_step(error.message)):
                failed.note(message)
            # At once: the exit handlers of rospy would wait for the master.
            leave_now(ExitStatus.STOPPED if signals.received else ExitStatus.REFUSED)
        client, keeper = ControlClient(events.put, Senders(rospy.get_namespace())), GraphKeeper()
        client.listen()
        client.set_watched(True)
        follower = SurveyFollower(options, client, shown, Clock())
        status = follower.run(events)
        for message in follower.last_words():
            (failed if status in (ExitStatus.REFUSED, ExitStatus.FAILED) else shown).note(message)
        # Said to a master that has ended: what rospy thinks of that must not be the last word.
        logging.getLogger("rosout").setLevel(logging.CRITICAL)
        keeper.close()
        client.close()
    return status
