"""The program doctor: asks the graph and this computer, and prints what is wrong."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from dataclasses import replace
from typing import Mapping, Tuple

import rosgraph
import rospy

from gpr20_common.catalogue import Catalogue, language_from_environment, read_catalogue
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_doctor import DEFAULT_WAIT_S, add_arguments, faults
from gpr20_doctor.high.graph import Graph
from gpr20_doctor.low.masters import MasterState, state_of
from gpr20_doctor.low.processes import Processes
from gpr20_doctor.mid.bundle import write_bundle
from gpr20_doctor.mid.findings import as_json, examine, exit_status, findings, lines
from gpr20_doctor.mid.machine import ROOT, Machine
from gpr20_doctor.mid.node_health import EXPECTED_NODES
from gpr20_doctor.mid.robot_checks import evidence_of
from gpr20_doctor.mid.robot_facts import RobotFacts, unheard
from gpr20_survey.plan.robot_description import NodeDescription

ANALYZER_LIMIT_S = 8.0
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
    add_arguments(parser)
    try:
        given = parser.parse_args(rosgraph.myargv()[1:])
    except SystemExit as ending:
        return REFUSED if ending.code else 0
    catalogue = read_catalogue(language_from_environment(os.environ))
    try:
        return run(given, catalogue)
    except KeyboardInterrupt:
        return REFUSED
    except BrokenPipeError:
        # The reader, such as `head`, has closed the pipe: the rest must not be written to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, RuntimeError, rospy.ROSException) as error:
        # ~USER without such a user, a master that ends while it is asked, a full disk.
        failed = Message("The doctor could not work: {reason}", reason=str(error))
        remedy = faults.CANNOT_WORK.remedy or failed
        say(catalogue.text(failed), f"-> {catalogue.text(remedy)}", file=sys.stderr)
    return REFUSED


def run(given: argparse.Namespace, catalogue: Catalogue) -> int:
    """Check everything and print it; return the exit status."""
    here, master = Processes(ROOT), rosgraph.get_master_uri()
    robot, nodes = _robot(given, master, here)
    machine = Machine.here(os.environ, ROOT, here.configuration(master), nodes)
    found = findings(robot, examine(machine))
    if given.json:
        print(as_json(found, catalogue), flush=True)  # noqa: T201
    else:
        say(*lines(found, catalogue), flush=True)
    if given.bundle is not None:
        missing = write_bundle(given.bundle, found, robot, machine)
        written = Message(
            "{file} is written. Not collected: {count}; `missing` in it says what and why.",
            file=given.bundle,
            count=len(missing),
        )
        say(catalogue.text(written), file=sys.stderr)
    return exit_status(found)


def _robot(
    given: argparse.Namespace, master: str, here: Processes
) -> Tuple[RobotFacts, Mapping[str, NodeDescription]]:
    clock = Clock()
    # A master that is starting gets time if it was asked for.
    until_s = clock.now_s() + (given.wait if given.wait > DEFAULT_WAIT_S else 0.0)
    while (state := state_of(master)) is not MasterState.ANSWERS and clock.now_s() < until_s:
        clock.wait_s(threading.Event(), POLL_S)
    if state is not MasterState.ANSWERS:
        return unheard(master, evidence_of(given.ns, state, master, here)), {}
    graph = Graph(given.ns, master, clock)
    try:
        graph.wait(given.wait)
        facts = graph.facts()
        if not facts.control_alive and len(graph.silent()) == len(EXPECTED_NODES):
            evidence = evidence_of(given.ns, state, master, here)
            if evidence.namespace not in evidence.robots:
                return unheard(master, evidence), {}
        if facts.control_alive and not (given.quick or facts.surveying):
            facts = replace(facts, analyzer=graph.test_analyzer(ANALYZER_LIMIT_S))
        return facts, graph.descriptions
    finally:
        rospy.signal_shutdown("the doctor has finished")
