"""Checks of what the robot's nodes report.

Each check is a function from the facts and this computer to findings. To add one, write
it and list it in CHECKS.
"""

from __future__ import annotations

from typing import Callable, Iterable, Iterator, Optional, Tuple

from gpr20_common.faults import (
    CONFIGURATION,
    INTERNAL,
    NOT_RUNNING,
    PART_LOST,
    PART_RED,
    PART_SILENT,
)
from gpr20_common.message import Message, Severity
from gpr20_doctor.low.masters import NodeState
from gpr20_doctor.mid.clock_checks import check_clocks
from gpr20_doctor.mid.contact_checks import check_contact
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine import Machine
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth, node_title
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_survey.faults import NOT_CALIBRATED, NOT_HOMED, VNA_SILENT
from gpr20_survey.plan.robot_description import ANALYZER
from gpr20_survey.trace.calibration import CalibrationStatus

Check = Callable[[RobotFacts, Machine], Iterable[Finding]]
# A node reports once a second; who has just begun to listen has not heard all of them [s].
STARTING_S = 5.0
WAIT = Message("Wait until all parts of the robot have started.")
MAKE_SURE = Message("Make sure that the VNA is calibrated.")


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


def check_parts(facts: RobotFacts, machine: Machine) -> Iterator[Finding]:
    """Judge each node by its own report, or by what it does when it is asked."""
    known = facts.evidence.nodes
    gone = [one.name for one in facts.nodes if known.get(one.name) is NodeState.GONE]
    if gone:
        text = Message("Not running: {parts}", parts=tuple(map(node_title, gone)))
        advice = Message("Wait one minute: what ends is started again by itself. If it stays:")
        yield Finding.of("missing", text, NOT_RUNNING, advice=machine.restart(advice))
    for node in facts.nodes:
        if node.name not in gone:
            yield _part(node, facts.listening_s, known.get(node.name))


def _part(node: NodeHealth, listening_s: float, state: Optional[NodeState]) -> Finding:
    name = node_title(node.name)
    if state is NodeState.HANGS:
        text = Message("{name} hangs: it runs, but does not answer.", name=name)
        return Finding.of(node.name, text, PART_LOST)
    if node.level is HealthLevel.OK:
        return Finding.of(node.name, name)
    if node.level is HealthLevel.STALE:
        text = Message("{name} does not report.", name=name)
        if listening_s > STARTING_S:
            return Finding.of(node.name, text, PART_SILENT)
        return Finding(node.name, Level.UNKNOWN, text, PART_SILENT.remedy)
    cause = node.message.cause
    text = Message("{name}: {state}", name=name, state=node.message)
    if node.level is HealthLevel.ERROR:
        return Finding.of(node.name, text, INTERNAL, advice=node.message.remedy)
    advice = node.message.remedy or Message("Press this part on ROBOT and read its details.")
    if cause is not None and (cause.severity is Severity.NOTE or cause == NOT_HOMED.as_warning()):
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
    elif node is not None:
        yield _calibration(node.values.get("calibration", ""))


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


CHECKS: Tuple[Check, ...] = (
    check_contact,
    check_configuration,
    check_parts,
    check_analyzer,
    check_clocks,
)
