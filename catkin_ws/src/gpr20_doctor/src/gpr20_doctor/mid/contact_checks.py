"""Checks of the contact with a robot, and why there is none."""

from __future__ import annotations

from typing import Iterator

from gpr20_common.faults import NODE_SILENT
from gpr20_common.message import Message
from gpr20_doctor import faults
from gpr20_doctor.low.masters import MasterState, NodeState
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.node_health import MAIN_CONTROL
from gpr20_doctor.mid.place import SERVER
from gpr20_doctor.mid.robot_facts import Evidence, RobotFacts

# The part itself says why it is silent.
SILENT = (NodeState.HANGS, NodeState.GONE)


def check_contact(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the contact with the ROS master and the main control."""
    if facts.unheard:
        yield Finding.of_fault("master", _why_unheard(facts.master, facts.evidence))
        return
    if not facts.master_alive:
        yield Finding.of_fault("master", _no_master(facts.master, facts.evidence))
    elif facts.control_alive:
        yield Finding("master", Level.OK, Message("Contact with the robot"))
    if not facts.control_alive and facts.evidence.nodes.get(MAIN_CONTROL) not in SILENT:
        text = Message("There is no contact with the main control.")
        yield Finding.of_fault("control", text.with_fault(NODE_SILENT))


def _why_unheard(master: str, evidence: Evidence) -> Message:
    """Return the one reason for which nothing of a robot is heard."""
    if evidence.robots:
        return Message(
            "There is no robot in the namespace {namespace}. On this ROS master there are: "
            "{robots}",
            namespace=evidence.namespace,
            robots=", ".join(evidence.robots),
            first=evidence.robots[0].strip("/") or "/",
        ).with_fault(faults.OTHER_NAMESPACE)
    # That of a master that hangs may move: it comes first.
    if evidence.elsewhere and evidence.master is not MasterState.HANGS:
        return _elsewhere(master, evidence).with_fault(faults.MASTER_ELSEWHERE)
    if evidence.master is MasterState.ANSWERS:
        text = Message("The ROS master answers, but it has no robot.", details=master)
        return text.with_fault(faults.NO_ROBOT)
    return _no_master(master, evidence)


def _elsewhere(master: str, evidence: Evidence) -> Message:
    values = {
        "master": master,
        "robots": ", ".join(f"{uri} ({robot})" for uri, robot in evidence.elsewhere),
        "first": evidence.elsewhere[0][0],
    }
    if evidence.master is MasterState.ANSWERS:
        return Message(
            "The ROS master {master} has no robot. Robots were found at: {robots}", **values
        )
    return Message("There is no ROS master at {master}. Robots were found at: {robots}", **values)


def _no_master(master: str, evidence: Evidence) -> Message:
    values = {"details": master, "service": SERVER}
    if evidence.master is MasterState.HANGS:
        text = Message(
            "The ROS master hangs: it does not answer. The robot may still move.", **values
        )
        return text.with_fault(faults.MASTER_HANGS)
    if evidence.master is MasterState.UNREACHABLE:
        text = Message("The computer of the ROS master is not reached.", details=master)
        return text.with_fault(faults.MASTER_UNREACHABLE)
    if evidence.local_nodes:
        return Message(
            "The ROS master has ended, but {count} parts of the robot still run on this computer. "
            "The robot may still move.",
            count=evidence.local_nodes,
            **values,
        ).with_fault(faults.MASTER_ENDED)
    text = Message("The ROS master does not answer.", **values)
    return text.with_fault(faults.NO_MASTER)


def check_unheard(facts: RobotFacts) -> Iterator[Finding]:
    """Say what nobody can tell while no node can be heard."""
    yield Finding(
        "parts",
        Level.UNKNOWN,
        Message("Axes, height sensor, VNA, storage and versions: not known without the robot."),
        Message("First do what the fault above says, then run gpr20 doctor again."),
    )
