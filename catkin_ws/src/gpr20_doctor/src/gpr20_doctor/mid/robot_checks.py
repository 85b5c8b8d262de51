"""Checks of what the robot's nodes report, of the contact with them, and why there is none.

Each check is a function from the facts and this computer to findings. To add one, write
it and list it in CHECKS.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Iterable, Iterator, Tuple

from gpr20_common.faults import (
    CONFIGURATION,
    INTERNAL,
    NOT_RUNNING,
    PART_LOST,
    PART_RED,
    PART_SILENT,
)
from gpr20_common.message import Message
from gpr20_doctor import faults
from gpr20_doctor.low.masters import MasterState, robots_at
from gpr20_doctor.low.processes import Processes
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine import Machine
from gpr20_doctor.mid.node_health import (
    MAIN_CONTROL,
    HealthLevel,
    NodeHealth,
    axis_node,
    node_title,
)
from gpr20_doctor.mid.robot_facts import Evidence, RobotFacts
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import CLOCK_WRONG, NOT_CALIBRATED, VNA_SILENT
from gpr20_survey.plan.robot_description import ANALYZER
from gpr20_survey.trace.sweep import CalibrationStatus

Check = Callable[[RobotFacts, Machine], Iterable[Finding]]
# A node reports once a second; who has just begun to listen has not heard all of them [s].
STARTING_S = 5.0
# A message is under way for some of it; times of traces are wrong by the rest [s].
OFFSET_LIMIT_S = 1.0
WAIT = Message("Wait until all parts of the robot have started.")
MAKE_SURE = Message("Make sure that the VNA is calibrated.")
TEST_IT = Message("When no survey runs: CHECK ALL on ROBOT, or gpr20 doctor without --quick.")
# What may still move something while it is silent.
MOVERS = (MAIN_CONTROL, *map(axis_node, AxisId))


def check_configuration(facts: RobotFacts, _machine: Machine) -> Iterator[Finding]:
    """Judge what the nodes say about themselves."""
    if facts.unheard:
        return
    if facts.configuration_problem is not None:
        reason = facts.configuration_problem
        text = Message("No survey can start: {reason}", reason=reason)
        yield Finding.of("configuration", text, CONFIGURATION)
    elif not facts.configured:
        text = Message("The robot's configuration is not known yet.")
        yield Finding("configuration", Level.UNKNOWN, text, WAIT)
    else:
        yield Finding.of("configuration", Message("Configuration of the robot"))
    if facts.simulated:
        text = Message("The robot is simulated: its data show no real ground.")
        real = Message("For the real robot launch with robot:=gpr20.")
        yield Finding("simulated", Level.NOTE, text, real)


def check_parts(facts: RobotFacts, _machine: Machine) -> Iterator[Finding]:
    """Judge each node by its own report; a silent one hangs, or has ended."""
    return (_part(node, facts.listening_s) for node in facts.nodes)


def _part(node: NodeHealth, listening_s: float) -> Finding:
    name = node_title(node.name)
    if node.level is HealthLevel.OK:
        return Finding.of(node.name, name)
    if node.level is HealthLevel.STALE:
        text = Message("{name} does not report.", name=name)
        if listening_s > STARTING_S:
            return Finding.of(node.name, text, PART_LOST if node.name in MOVERS else PART_SILENT)
        return Finding(node.name, Level.UNKNOWN, text, PART_SILENT.remedy)
    text = Message("{name}: {state}", name=name, state=node.message)
    if node.level is HealthLevel.ERROR:
        return Finding.of(node.name, text, INTERNAL, advice=node.message.remedy)
    advice = node.message.remedy or Message("Press this part on ROBOT and read its details.")
    if node.rating is Level.NOTE:
        return Finding(node.name, Level.NOTE, text, advice)
    return Finding.of(node.name, text, PART_RED, mild=True, advice=advice)


def check_analyzer(facts: RobotFacts, _machine: Machine) -> Iterator[Finding]:
    """Judge the test of the VNA, or what its driver reports where it was not tested."""
    test, node = facts.analyzer, facts.node(ANALYZER)
    if test is not None and test.failure is not None:
        text = Message("Test of the VNA: {reason}", reason=test.failure)
        yield Finding.of("vna", text, VNA_SILENT)
    elif test is not None:
        yield _calibration(test.calibration)
    elif not facts.unheard:
        untested = Message("The VNA was not tested: whether it measures now is not known.")
        beside = Message("The VNA is not tested beside a survey; its driver reports no fault.")
        is_well = facts.surveying and node is not None and node.level is HealthLevel.OK
        level, said = (Level.NOTE, beside) if is_well else (Level.UNKNOWN, untested)
        yield Finding("vna", level, said, TEST_IT)
        if node is not None:
            last = _calibration(node.values.get("calibration", ""))
            text = Message("When it was last read: {state}", state=last.text)
            # What was good then may not be now.
            yield last if last.level > Level.OK else replace(last, level=Level.NOTE, text=text)


def _calibration(name: str) -> Finding:
    status = CalibrationStatus.__members__.get(name)
    if status is None:
        text = Message("The calibration of the VNA has not been read yet.", details=name)
        return Finding("calibration", Level.UNKNOWN, text, MAKE_SURE)
    text = Message("Calibration of the VNA: {state}", state=status.meaning)
    good, none = status is CalibrationStatus.HIGH, status is CalibrationStatus.NONE
    advice = MAKE_SURE if status is CalibrationStatus.NOT_REPORTED else None
    fault = None if good else NOT_CALIBRATED
    return Finding.of("calibration", text, fault, mild=not none, advice=advice)


def check_clocks(facts: RobotFacts, _machine: Machine) -> Iterator[Finding]:
    """Compare the clocks of the nodes with this one."""
    offsets_s = facts.clock_offsets_s
    if not offsets_s:
        return
    node = max(offsets_s, key=lambda one: abs(offsets_s[one]))
    if abs(offsets_s[node]) <= OFFSET_LIMIT_S:
        yield Finding.of("clocks", Message("Clocks of the computers"))
        return
    text = Message(
        "The clock of {node} differs from this computer's by {offset_s:.1f} s.",
        node=node_title(node),
        offset_s=abs(offsets_s[node]),
        details=facts.software[node].host if node in facts.software else "",
    )
    advice = Message("Set the clocks of both computers, but not during a survey: install chrony.")
    yield Finding.of("clocks", text, CLOCK_WRONG, mild=True, advice=advice)


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
    elif not facts.control_alive and facts.node(MAIN_CONTROL) is not None:
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
    known = {
        MasterState.ANSWERS: (
            Message("The ROS master answers, but it has no robot."),
            machine.restart(Message("Nothing of the robot was started.")),
        ),
        MasterState.FOREIGN: (
            Message("Another program listens where the ROS master should."),
            Message(
                "To see which, run: sudo ss -ltnp. End that program, or write another port into "
                "{where}. Then start the robot again.",
                where=where,
            ),
        ),
        MasterState.UNKNOWN_HOST: (
            Message("Nobody knows the name of the ROS master's computer."),
            Message(
                "Correct the name in {where}, use an address such as 10.20.0.2 instead, or write "
                "name and address into /etc/hosts.",
                where=where,
            ),
        ),
        MasterState.UNREACHABLE: (
            Message("The computer of the ROS master is not reached."),
            Message(
                "Check that the other computer is switched on, the cable between them, and the "
                "address ({where}).",
                where=where,
            ),
        ),
        MasterState.NOT_THERE: (
            Message("The ROS master does not answer."),
            machine.restart(Message("The robot does not run.")),
        ),
    }
    return known[state]


CHECKS: Tuple[Check, ...] = (
    check_contact,
    check_configuration,
    check_parts,
    check_analyzer,
    check_clocks,
)
