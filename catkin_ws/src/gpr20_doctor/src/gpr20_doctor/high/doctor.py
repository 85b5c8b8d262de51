"""The program doctor: asks the graph and this computer, and prints what is wrong."""

from __future__ import annotations

import argparse
import os
import signal
import socket
import sys
import threading
from dataclasses import replace
from typing import Callable, List, Mapping, Optional, Tuple

import rosgraph
import rospy

from gpr20_common.catalogue import (
    Catalogue,
    language_from_code,
    language_from_environment,
    languages,
    read_catalogue,
)
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_doctor import faults
from gpr20_doctor.high.graph import Graph
from gpr20_doctor.low import masters, network, system
from gpr20_doctor.low.masters import MasterState, NodeState
from gpr20_doctor.mid.arguments import DEFAULT_WAIT_S, add_arguments
from gpr20_doctor.mid.bundle import write_bundle
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import as_json, exit_status, findings, lines
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import AUTOMATIC, REAL, ROOT, MachineRequest, ThisMachine
from gpr20_doctor.mid.node_health import EXPECTED_NODES
from gpr20_doctor.mid.robot_facts import Evidence, RobotFacts, unheard
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
        found, robot, request = _find(given)
    except (OSError, RuntimeError, rospy.ROSException) as error:
        # ~USER without such a user, a master that ends while it is asked.
        return _refused(error, catalogue)
    if given.json:
        print(as_json(found, catalogue), flush=True)
    else:
        say(*lines(found, catalogue), flush=True)
    if given.bundle is not None:
        try:
            missing = write_bundle(given.bundle, found, robot, request)
        except OSError as error:
            return _refused(error, catalogue)
        written = Message(
            "{file} is written. {count} parts could not be collected: index.json in it says why.",
            file=given.bundle,
            count=len(missing),
        )
        say(catalogue.text(written), file=sys.stderr)
    return exit_status(found)


def _refused(error: Exception, catalogue: Catalogue) -> int:
    failed = Message("The doctor could not work: {reason}", reason=str(error))
    failed = failed.with_fault(faults.CANNOT_WORK)
    say(catalogue.text(failed), file=sys.stderr)
    if failed.remedy is not None:
        say(f"-> {catalogue.text(failed.remedy)}", file=sys.stderr)
    return REFUSED


def _find(
    given: argparse.Namespace,
) -> Tuple[Tuple[Finding, ...], RobotFacts, MachineRequest]:
    here, master = system.ros_processes(ROOT), rosgraph.get_master_uri()
    config = given.config or here.configuration(master)
    machine = ThisMachine(socket.gethostname(), os.environ, config=config)
    robot, nodes = _robot(given, master, lambda state: _evidence(given.ns, state, here, machine))
    ports = masters.node_ports(robot.master) if robot.master_alive else frozenset()
    # A configuration is that of a real robot, whatever runs now.
    asked = given.config is not None and given.robot == AUTOMATIC
    files = REAL if asked else given.robot
    request = machine.request(nodes, robot.surveying, given.robot, not given.quick, files, ports)
    return findings(robot, probe_machine(request)), robot, request


def _robot(
    given: argparse.Namespace, master: str, search: Callable[[MasterState], Evidence]
) -> Tuple[RobotFacts, Mapping[str, NodeDescription]]:
    state = _state_of_master(master, given.wait)
    if state is not MasterState.ANSWERS:
        return unheard(master, search(state)), {}
    graph = Graph(given.ns, master)
    try:
        graph.listener.wait(given.wait)
        silent = graph.node_states(graph.listener.silent())
        gone = {name for name, one in silent.items() if one is NodeState.GONE}
        nobody = gone.issuperset(EXPECTED_NODES)
        if nobody and not graph.listener.facts().control_alive:
            return unheard(master, search(state)), {}
        analyzer = None if given.quick else _test(graph)
        facts = graph.listener.facts(analyzer)
        evidence = Evidence(state, graph.namespace, nodes=silent)
        return replace(facts, evidence=evidence), graph.listener.descriptions
    finally:
        graph.leave()


def _evidence(
    namespace: str, state: MasterState, here: system.RosProcesses, machine: ThisMachine
) -> Evidence:
    """Look for the robot where it could be: in other namespaces, and at other masters."""
    own = rosgraph.get_master_uri().rstrip("/")
    local = [one.master for one in here.nodes]
    hosts = ["localhost", *(machine.environment.get(name, "") for name in network.ADDRESSES)]
    ports = [system.DEFAULT_PORT, *here.ports]
    places = [f"http://{host}:{port}" for port in ports for host in hosts if host]
    return Evidence(
        master=state,
        namespace="/" + namespace.strip("/"),
        robots=masters.robots_at(own) if state is MasterState.ANSWERS else (),
        elsewhere=masters.robots_elsewhere(own, [*filter(None, local), *places]),
        local_nodes=len(here.nodes_of(own)),
    )


def _state_of_master(master: str, limit_s: float) -> MasterState:
    """Return whether the master answers; one that is starting gets time if it was asked for."""
    clock = Clock()
    deadline_s = clock.now_s() + (limit_s if limit_s > DEFAULT_WAIT_S else 0.0)
    while True:
        state = masters.state_of(master)
        if state is MasterState.ANSWERS or clock.now_s() >= deadline_s:
            return state
        clock.wait_s(threading.Event(), POLL_S)


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
