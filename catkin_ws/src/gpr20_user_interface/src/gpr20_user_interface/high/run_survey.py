"""The terminal client: run a survey without a window."""

from __future__ import annotations

import argparse
import io
import os
import queue
import sys
from typing import List

import rospy

from gpr20_common.catalogue import Catalogue, language_from_environment, read_catalogue
from gpr20_common.high.graph_keeper import GraphKeeper
from gpr20_common.low.clock import Clock
from gpr20_common.terminal_text import say
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.high.ros_events import RequestError, join_graph
from gpr20_operator.high.storage_client import StorageClient
from gpr20_operator.jobs.job import Service
from gpr20_operator.jobs.pictures import SURVEYS_PER_PAGE
from gpr20_operator.robot.events import Senders
from gpr20_user_interface.low.process import SecondStopSignal, StopSignals, leave_now
from gpr20_user_interface.terminal.follower import (
    Display,
    ExitStatus,
    StopRequested,
    SurveyFollower,
    first_step,
)
from gpr20_user_interface.terminal.survey_arguments import parse_arguments

# Of the surveys that can be resumed.
MOST_NAMED = 5


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
    senders = Senders(rospy.get_namespace())
    client, storage = ControlClient(events.put, senders), StorageClient(events.put, senders)

    def ask() -> None:
        if options.resume is not None:
            client.resume_survey(options.resume)
        else:
            client.start_survey(options.plan)

    display = Display(sys.stdout, catalogue)
    follower = SurveyFollower(ask, client.stop, display, options.wait, Clock())
    client.listen()
    client.set_watched(True)
    keeper = GraphKeeper()
    status = follower.run(events)
    display.close()
    is_error = status in (ExitStatus.REFUSED, ExitStatus.FAILED)
    last = Display(sys.stderr if is_error else sys.stdout, catalogue)
    for message in follower.last_words(lambda: _resumable(storage)):
        last.note(message)
    keeper.close()
    client.close()
    return status


def _resumable(storage: StorageClient) -> List[str]:
    """Return the ids of the newest surveys that ended early; none if nobody can list them."""
    try:
        newest = storage.wait_for(Service.LIST, before="", max_surveys=SURVEYS_PER_PAGE)
    except RequestError as error:
        rospy.logwarn("no survey can be named: %s", error)
        return []
    past = PastSurveys()
    return [one.survey_id for one in newest.surveys if past.can_resume(one)][:MOST_NAMED]
