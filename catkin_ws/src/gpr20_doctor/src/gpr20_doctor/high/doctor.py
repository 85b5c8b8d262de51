"""The program doctor: asks the graph and this computer, and prints what is wrong."""

from __future__ import annotations

import argparse
import os
import signal
import socket
import sys
import threading
from typing import List, Mapping, Optional, Tuple

import rosgraph
import rospy

from gpr20_common.catalogue import Catalogue
from gpr20_common.low.catalogue_file import (
    language_from_code,
    language_from_environment,
    languages,
    read_catalogue,
)
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_doctor import faults
from gpr20_doctor.high.graph import Graph, master_answers
from gpr20_doctor.mid.arguments import DEFAULT_WAIT_S, add_arguments
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import exit_status, findings
from gpr20_doctor.mid.listener import without_master
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import ThisMachine
from gpr20_doctor.mid.output import as_json, lines
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_survey.plan.robot_description import ANALYZER, HEIGHT_SENSOR, NodeDescription
from gpr20_survey.results.analyzer_test import AnalyzerTest

HEIGHT_LIMIT_S = 5.0
ANALYZER_LIMIT_S = 8.0
REPORT_LIMIT_S = 2.5
POLL_S = 0.5
REFUSED = 3
EXIT_STATUS = (
    "exit status: 0 nothing is wrong, 1 a warning or something unknown, 2 a fault, 3 the doctor "
    "itself could not work"
)


def main() -> int:
    """Print what is wrong with the robot; return the exit status."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    parser = argparse.ArgumentParser("doctor", description=__doc__, epilog=EXIT_STATUS)
    parser.add_argument("--language", choices=[one.value for one in languages()])
    add_arguments(parser)
    try:
        given = parser.parse_args(rosgraph.myargv()[1:])
    except SystemExit as ending:
        return REFUSED if ending.code else 0
    language = (
        language_from_environment(os.environ)
        if given.language is None
        else language_from_code(given.language)
    )
    try:
        return run(given, read_catalogue(language))
    except KeyboardInterrupt:
        return REFUSED
    except BrokenPipeError:
        # The reader, such as `head`, has closed the pipe: the rest must not be written to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return REFUSED


def run(given: argparse.Namespace, catalogue: Catalogue) -> int:
    """Check everything and print it; return the exit status."""
    try:
        found = _find(given)
    except (OSError, RuntimeError, rospy.ROSException) as error:
        # ~USER without such a user, a master that ends while it is asked.
        failed = Message("The doctor could not work: {reason}", reason=str(error))
        failed = failed.with_fault(faults.CANNOT_WORK)
        say(catalogue.text(failed), file=sys.stderr)
        if failed.remedy is not None:
            say(f"-> {catalogue.text(failed.remedy)}", file=sys.stderr)
        return REFUSED
    if given.json:
        print(as_json(found, catalogue), flush=True)
    else:
        say(*lines(found, catalogue), flush=True)
    return exit_status(found)


def _find(given: argparse.Namespace) -> Tuple[Finding, ...]:
    robot, nodes = _robot(given)
    machine = ThisMachine(socket.gethostname(), os.environ, config=given.config)
    request = machine.request(nodes, robot.surveying, given.robot, not given.quick)
    return findings(robot, probe_machine(request))


def _robot(given: argparse.Namespace) -> Tuple[RobotFacts, Mapping[str, NodeDescription]]:
    master = rosgraph.get_master_uri()
    if not _wait_for_master(master, given.wait):
        return without_master(master), {}
    graph = Graph(given.ns, master)
    try:
        graph.listener.wait(given.wait)
        analyzer = None if given.quick else _test(graph)
        return graph.listener.facts(analyzer), graph.listener.descriptions
    finally:
        graph.leave()


def _wait_for_master(master: str, limit_s: float) -> bool:
    """Return whether the master answers; one that is starting gets time if it was asked for."""
    clock = Clock()
    deadline_s = clock.now_s() + (limit_s if limit_s > DEFAULT_WAIT_S else 0.0)
    while not master_answers(master):
        if clock.now_s() >= deadline_s:
            return False
        clock.wait_s(threading.Event(), POLL_S)
    return True


def _test(graph: Graph) -> Optional[AnalyzerTest]:
    """Test VNA and height sensor, if no survey needs them."""
    known = graph.listener.facts()
    if known.surveying or not known.control_alive:
        return None
    found: List[AnalyzerTest] = []
    analyzer = threading.Thread(
        target=lambda: found.append(graph.test_analyzer(ANALYZER_LIMIT_S)), daemon=True
    )
    analyzer.start()
    graph.measure_height(HEIGHT_LIMIT_S)
    analyzer.join()
    graph.listener.wait_for_next((ANALYZER, HEIGHT_SENSOR), REPORT_LIMIT_S)
    return found[0] if found else None
