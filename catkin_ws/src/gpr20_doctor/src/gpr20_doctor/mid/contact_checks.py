"""Checks of the contact with a robot, why there is none, and of the software of its parts."""

from __future__ import annotations

from typing import Iterable, Iterator, Mapping

from gpr20_common.faults import NOT_RUNNING, OTHER_LAUNCH, PART_SILENT, VERSIONS_DIFFER
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NodeSoftware, software_difference
from gpr20_doctor import faults
from gpr20_doctor.low.masters import MasterState, NodeState
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.node_health import (
    DRIVERS,
    EXPECTED_NODES,
    IMAGING,
    MAIN_CONTROL,
    node_title,
)
from gpr20_doctor.mid.place import ROBOT, SERVER
from gpr20_doctor.mid.robot_facts import Evidence, RobotFacts

MOTORS_FIRST = Message(
    "Switch off the motors' power. Then end the ROS master and start the robot again."
)
WAIT = Message("Wait until all parts of the robot have started.")
# The part itself says why it is silent.
SILENT = (NodeState.HANGS, NodeState.GONE, NodeState.UNREACHED)


def check_contact(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the contact with the ROS master and the main control."""
    if facts.unheard:
        yield _why_unheard(facts.master, facts.evidence)
        return
    if not facts.master_alive:
        yield _no_master(facts.master, facts.evidence)
    elif facts.control_alive:
        yield Finding.of("master", Message("Contact with the robot"))
    if not facts.control_alive and facts.evidence.nodes.get(MAIN_CONTROL) not in SILENT:
        text = Message("There is no contact with the main control.")
        yield Finding.of("control", text, PART_SILENT)


def _why_unheard(master: str, evidence: Evidence) -> Finding:
    """Return the one reason for which nothing of a robot is heard."""
    if evidence.robots:
        text = Message(
            "There is no robot in the namespace {namespace}. On this ROS master there are: "
            "{robots}",
            namespace=evidence.namespace,
            robots=", ".join(evidence.robots),
        )
        advice = Message(
            "Run: gpr20 doctor --ns {robot}. For every program in this terminal: export "
            "ROS_NAMESPACE={robot}",
            robot=evidence.robots[0].strip("/") or "/",
        )
        return Finding.of("master", text, NOT_RUNNING, advice=advice)
    # That of a master that hangs may move: it comes first.
    if evidence.elsewhere and evidence.master is not MasterState.HANGS:
        advice = Message(
            "Run: export ROS_MASTER_URI={first}. Then run the doctor again.",
            first=evidence.elsewhere[0][0],
        )
        values = {
            "master": master,
            "robots": ", ".join(f"{uri} ({robot})" for uri, robot in evidence.elsewhere),
        }
        text = Message(
            "There is no ROS master at {master}. Robots were found at: {robots}", **values
        )
        if evidence.master is MasterState.ANSWERS:
            text = Message(
                "The ROS master {master} has no robot. Robots were found at: {robots}", **values
            )
        return Finding.of("master", text, NOT_RUNNING, advice=advice)
    if evidence.master is MasterState.ANSWERS:
        text = Message("The ROS master answers, but it has no robot.", details=master)
        return Finding.of("master", text, NOT_RUNNING, restart="")
    return _no_master(master, evidence)


def _no_master(master: str, evidence: Evidence) -> Finding:
    if evidence.master is MasterState.UNREACHABLE:
        text = Message("The computer of the ROS master is not reached.", details=master)
        advice = Message(
            "Check that the other computer is switched on, the cable between them, and the address "
            "({where}).",
            where="GPR20_SERVER, ROS_MASTER_URI",
        )
        return Finding.of("master", text, NOT_RUNNING, advice=advice)
    if evidence.master is MasterState.HANGS:
        text = Message("The ROS master hangs: it does not answer. The robot may still move.")
    elif evidence.local_nodes:
        text = Message(
            "The ROS master has ended, but {count} parts of the robot still run on this computer. "
            "The robot may still move.",
            count=evidence.local_nodes,
        )
    else:
        text = Message("The ROS master does not answer.", details=master)
        return Finding.of("master", text, NOT_RUNNING, restart=SERVER)
    text = text.with_details(master)
    return Finding.of("master", text, faults.MASTER_LOST, advice=MOTORS_FIRST, restart=SERVER)


def check_unheard(facts: RobotFacts) -> Iterator[Finding]:
    """Say what nobody can tell while no node can be heard."""
    yield Finding(
        "parts",
        Level.UNKNOWN,
        Message("Axes, height sensor, VNA, storage and versions: not known without the robot."),
        Message("First do what the fault above says, then run gpr20 doctor again."),
    )


def service_of(nodes: Iterable[str]) -> str:
    """Return the service that starts some nodes; empty if two do."""
    services = {ROBOT if name in DRIVERS else SERVER for name in nodes}
    return services.pop() if len(services) == 1 else ""


def check_versions(facts: RobotFacts) -> Iterator[Finding]:
    """Compare the software of the nodes."""
    if not facts.control_alive:
        return
    software = facts.software
    silent = next((node for node, one in software.items() if not one.version), None)
    difference = software_difference(software)
    # The node of the images does not describe itself.
    expected = {*EXPECTED_NODES} - {IMAGING, *software}
    missing = [one.name for one in facts.nodes if one.name in expected]
    if not software:
        text = Message("The software of the parts is not known yet.")
        yield Finding("versions", Level.UNKNOWN, text, WAIT)
    elif difference is not None:
        hosts = [_on(host, software) for host in sorted({one.host for one in software.values()})]
        mixed = next((nodes for nodes in hosts if software_difference(nodes)), {})
        text = Message("Versions: {difference}", difference=difference)
        yield _differing("versions", text, mixed)
    elif silent is not None:
        text = Message("{part} does not say which software it runs.", part=node_title(silent))
        yield Finding("versions", Level.UNKNOWN, text, VERSIONS_DIFFER.remedy)
    elif missing:
        text = Message("Not known: the software of {parts}", parts=tuple(map(node_title, missing)))
        yield Finding("versions", Level.UNKNOWN, text, VERSIONS_DIFFER.remedy)
    else:
        name = next(iter(software.values())).name
        text = Message("Software {software} on every part", software=name)
        yield Finding.of("versions", text)


def check_installed(facts: RobotFacts, installed: NodeSoftware) -> Iterator[Finding]:
    """Compare the software of this computer with its parts, or else with the main control."""
    here = _on(installed.host, facts.software)
    main = facts.software.get(MAIN_CONTROL)
    running = here or ({} if main is None else {MAIN_CONTROL: main})
    other = next((one for one in running.values() if one.name not in ("", installed.name)), None)
    if other is not None:
        text = Message(
            "The robot runs the software {running}, but {installed} is installed here.",
            running=other.name,
            installed=installed.name,
        )
        yield _differing("installed", text, here)


def _differing(check: str, text: Message, here: Iterable[str]) -> Finding:
    """Return that the software differs on one computer, whose nodes are given, or between two."""
    if not here:
        fault = VERSIONS_DIFFER.as_warning()
        return Finding.of(check, text.reporting_only(fault), fault)
    fault, service = OTHER_LAUNCH.as_warning(), service_of(here)
    advice = Message("Start all parts of the robot again, from one installation.")
    return Finding.of(check, text.reporting_only(fault), fault, advice=advice, restart=service)


def _on(host: str, software: Mapping[str, NodeSoftware]) -> Mapping[str, NodeSoftware]:
    return {node: one for node, one in software.items() if one.host == host}
