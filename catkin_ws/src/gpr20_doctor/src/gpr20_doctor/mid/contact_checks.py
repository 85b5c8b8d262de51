"""Checks of the contact with a robot, and why there is none."""

from __future__ import annotations

from typing import Iterator, Tuple

from gpr20_common.faults import NOT_RUNNING, PART_SILENT
from gpr20_common.message import Message
from gpr20_doctor import faults
from gpr20_doctor.low.masters import MasterState, NodeState, robots_at
from gpr20_doctor.low.processes import Processes
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine import Machine
from gpr20_doctor.mid.node_health import MAIN_CONTROL
from gpr20_doctor.mid.robot_facts import Evidence, RobotFacts

# The part itself says why it is silent.
SILENT = (NodeState.HANGS, NodeState.GONE)


def evidence_of(namespace: str, state: MasterState, master: str, here: Processes) -> Evidence:
    """Look for a robot that is not heard where it could be.

    Args:
        namespace: Where it was looked for.
        state: Whether the master answers.
        master: Its address.
        here: What runs on this computer.
    """
    own = here.nodes_of(master)
    if state is MasterState.HANGS and here.lacks_master(master):
        state = MasterState.FOREIGN  # what takes calls there is no master
    return Evidence(
        master=state,
        namespace="/" + namespace.strip("/"),
        robots=robots_at(master) if state is MasterState.ANSWERS else (),
        elsewhere=tuple(sorted({one.master for one in here.nodes if one not in own})),
        local_nodes=len(own),
    )


def check_contact(facts: RobotFacts, machine: Machine) -> Iterator[Finding]:
    """Judge the contact with the ROS master and the main control."""
    if facts.unheard or not facts.master_alive:
        yield _why_unheard(facts.master, facts.evidence, machine)
    elif facts.control_alive:
        yield Finding.of("master", Message("Contact with the robot"))
    if facts.unheard:
        text = Message("Axes, height sensor, VNA, storage and versions: not known without a robot.")
        advice = Message("First do what the fault above says, then run gpr20 doctor again.")
        yield Finding("parts", Level.UNKNOWN, text, advice)
    elif not facts.control_alive and facts.evidence.nodes.get(MAIN_CONTROL) not in SILENT:
        text = Message("There is no contact with the main control.")
        yield Finding.of("control", text, PART_SILENT)


def _why_unheard(master: str, evidence: Evidence, machine: Machine) -> Finding:
    """Return the one reason for which nothing of a robot is heard; what may move comes first."""
    fault, advice = NOT_RUNNING, None
    if evidence.master is MasterState.HANGS:
        fault = faults.MASTER_LOST
        text = Message("The ROS master hangs: it does not answer. The robot may still move.")
    elif evidence.local_nodes and evidence.master is not MasterState.ANSWERS:
        fault = faults.MASTER_LOST
        text = Message(
            "The ROS master has ended, but {count} parts of the robot still run on this computer. "
            "The robot may still move.",
            count=evidence.local_nodes,
        )
    elif evidence.robots:
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
    elif evidence.elsewhere:
        text = Message(
            "There is no robot at this ROS master, but parts of one run here with another one: "
            "{others}",
            others=", ".join(evidence.elsewhere),
        )
        advice = Message(
            "Run: export ROS_MASTER_URI={first}. Then run the doctor again.",
            first=evidence.elsewhere[0],
        )
    else:
        text, advice = _without_robot(evidence.master, machine)
    return Finding.of("master", text.with_details(master), fault, advice=advice)


def _without_robot(state: MasterState, machine: Machine) -> Tuple[Message, Message]:
    where = str(machine.settings or "ROS_MASTER_URI")
    if state is MasterState.ANSWERS:
        text = Message("The ROS master answers, but it has no robot.")
        return text, machine.restart(Message("Nothing of the robot was started."))
    if state is MasterState.FOREIGN:
        text = Message("Another program listens where the ROS master should.")
        advice = Message(
            "To see which, run: sudo ss -ltnp. End that program, or write another port into "
            "{where}. Then start the robot again.",
            where=where,
        )
        return text, advice
    if state is MasterState.UNKNOWN_HOST:
        text = Message("Nobody knows the name of the ROS master's computer.")
        advice = Message(
            "Correct the name in {where}, use an address such as 10.20.0.2 instead, or write name "
            "and address into /etc/hosts.",
            where=where,
        )
        return text, advice
    if state is MasterState.UNREACHABLE:
        text = Message("The computer of the ROS master is not reached.")
        advice = Message(
            "Check that the other computer is switched on, the cable between them, and the address "
            "({where}).",
            where=where,
        )
        return text, advice
    text = Message("The ROS master does not answer.")
    return text, machine.restart(Message("The robot does not run."))
