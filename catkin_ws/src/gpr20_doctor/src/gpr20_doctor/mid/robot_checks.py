"""Checks of what the robot's nodes report.

Each check is a function from the facts to findings. To add one, write it and list it in CHECKS.
"""

from __future__ import annotations

import math
from typing import Callable, Iterable, Iterator, Optional, Tuple

from gpr20_common.faults import (
    CONFIGURATION,
    DISK_FULL,
    INTERNAL,
    NOT_RUNNING,
    PART_LOST,
    PART_RED,
    PART_SILENT,
)
from gpr20_common.message import Message, Severity, verbatim
from gpr20_doctor import faults
from gpr20_doctor.low.masters import NodeState
from gpr20_doctor.mid.contact_checks import (
    WAIT,
    check_contact,
    check_unheard,
    check_versions,
    service_of,
)
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth, axis_node, node_title
from gpr20_doctor.mid.robot_facts import AxisReport, Endstop, RobotFacts
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import (
    CLOCK_WRONG,
    ENDSTOP,
    HEIGHT_NOT_MEASURED,
    NO_GROUND,
    NOT_CALIBRATED,
    NOT_HOMED,
    VNA_SILENT,
    WRONG_VNA,
)
from gpr20_survey.plan.robot_description import (
    ANALYZER,
    HEIGHT_SENSOR,
    STORAGE,
    is_simulated_identity,
)
from gpr20_survey.trace.calibration import CalibrationStatus

TEST = Message("A survey reads it; or test the VNA on ROBOT.")
MAKE_SURE = Message("Make sure that the VNA is calibrated.")
CHECK_LINK = Message(
    "Check the link, and the address of this computer. Then start the robot again."
)


def check_analyzer(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the test of the VNA, or what its driver reports where it was not tested."""
    test = facts.analyzer
    if test is not None and test.failure is not None:
        text = Message("Test of the VNA: {reason}", reason=test.failure)
        yield Finding.of("vna", text, VNA_SILENT)
    known = facts.reported(ANALYZER) if test is None else test
    identity, calibration = ("", "") if known is None else (known.identity, known.calibration)
    if identity:
        yield _identity(identity, facts.simulated)
    if calibration or test is None or test.failure is None:
        yield _calibration(calibration)


def _calibration(name: str) -> Finding:
    if not name:
        text = Message("The calibration of the VNA has not been read yet.")
        return Finding("calibration", Level.UNKNOWN, text, TEST)
    status = CalibrationStatus.__members__.get(name)
    state = verbatim(name) if status is None else status.meaning
    text = Message("Calibration of the VNA: {state}", state=state)
    if status is None:
        return Finding("calibration", Level.UNKNOWN, text, MAKE_SURE)
    good, none = status is CalibrationStatus.HIGH, status is CalibrationStatus.NONE
    advice = MAKE_SURE if status is CalibrationStatus.NOT_REPORTED else None
    fault = None if good else NOT_CALIBRATED
    return Finding.of("calibration", text, fault, mild=not none, advice=advice)


def _identity(identity: str, simulated: bool) -> Finding:
    if is_simulated_identity(identity) == simulated:
        return Finding.of("identity", Message("VNA: {identity}", identity=identity))
    text = Message(
        "The VNA {identity} and the robot are not both simulated or both real.",
        identity=identity,
    )
    return Finding.of("identity", text, WRONG_VNA)


# A node reports once a second; who has just begun to listen has not heard all of them [s].
STARTING_S = 5.0
LOW_DISK_GB = 5.0
FULL_DISK_GB = 0.5
MEGABYTES_PER_GIGABYTE = 1000.0
# A message is under way for some of it; times of traces are wrong by the rest [s].
CLOCK_OFFSET_LIMIT_S = 1.0
# An endstop is at the zero of its axis: farther away than this it cannot be pressed [mm].
ENDSTOP_REACH_MM = 5.0
# Antennas that are lower touch the ground; at a greater height they measure little of it [m].
USUAL_HEIGHT_M = (0.01, 0.6)

Check = Callable[[RobotFacts], Iterable[Finding]]


def check_configuration(facts: RobotFacts) -> Iterator[Finding]:
    """Judge what the nodes say about themselves."""
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


def check_parts(facts: RobotFacts) -> Iterator[Finding]:
    """Judge each node by its own report."""
    known = facts.evidence.nodes
    gone = [one.name for one in facts.nodes if known.get(one.name) is NodeState.GONE]
    lost = [one.name for one in facts.nodes if known.get(one.name) is NodeState.UNREACHED]
    if gone:
        text = Message("Not running: {parts}", parts=tuple(map(node_title, gone)))
        advice = Message(
            "Wait one minute: what ends is started again by itself. If it stays, start the robot "
            "again."
        )
        yield Finding.of("missing", text, NOT_RUNNING, advice=advice, restart=service_of(gone))
    if lost:
        parts, service = tuple(map(node_title, lost)), service_of(lost)
        text = Message("Not reached at the address where they listen: {parts}", parts=parts)
        yield Finding.of("missing", text, faults.ADDRESS, advice=CHECK_LINK, restart=service)
    for node in facts.nodes:
        if node.name not in {*gone, *lost}:
            yield _part(node, facts.listening_s, known.get(node.name))


def check_disk(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the space for recordings."""
    reported = facts.reported(STORAGE)
    free_mb = None if reported is None else reported.free_disk_mb
    if free_mb is None:
        text = Message("The free disk space is not known.")
        wait = Message("It is known when the storage reports.")
        yield Finding("disk", Level.UNKNOWN, text, wait)
    else:
        yield disk_space("disk", free_mb / MEGABYTES_PER_GIGABYTE)


def disk_space(check: str, free_gb: float) -> Finding:
    """Judge the space on the disk of the surveys [GB]."""
    text = Message("Disk: {free_gb:.1f} GB free", free_gb=free_gb)
    fault = DISK_FULL if free_gb < LOW_DISK_GB else None
    return Finding.of(check, text, fault, mild=free_gb >= FULL_DISK_GB)


def check_height(facts: RobotFacts) -> Iterator[Finding]:
    """Judge whether the last height can be one of the antennas."""
    node, height_m = facts.node(HEIGHT_SENSOR), facts.height_m
    if node is None or node.level is HealthLevel.ERROR:
        return  # the part itself says why
    lowest_m, highest_m = USUAL_HEIGHT_M
    if not math.isfinite(height_m):
        text = Message("The height of the antennas has not been measured yet.")
        yield Finding("height", Level.UNKNOWN, text, HEIGHT_NOT_MEASURED.remedy)
    elif lowest_m <= height_m <= highest_m:
        text = Message("Height of the antennas: {height_m:.3f} m", height_m=height_m)
        yield Finding.of("height", text)
    else:
        text = Message(
            "The height of the antennas is {height_m:.3f} m; expected {lowest_m:g} to "
            "{highest_m:g} m.",
            height_m=height_m,
            lowest_m=lowest_m,
            highest_m=highest_m,
        )
        advice = Message(
            "Look below the sensor, and check the offset in {height_file}.",
            height_file="height.yaml",
        )
        yield Finding.of("height", text, NO_GROUND, mild=True, advice=advice)


def check_endstops(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the endstops, and find one that is closed where its axis cannot press it."""
    for axis_id in (AxisId.X, AxisId.Y):
        seen, position = facts.endstops.get(axis_id), facts.axes.get(axis_id)
        if facts.node(axis_node(axis_id)) and seen is not None and position is not None:
            yield _endstop(axis_id, position, seen)


def check_clocks(facts: RobotFacts) -> Iterator[Finding]:
    """Compare the clocks of the computers."""
    worst = max(facts.clock_offsets_s.items(), key=lambda one: abs(one[1]), default=None)
    if worst is None:
        return
    node, offset_s = worst
    if abs(offset_s) <= CLOCK_OFFSET_LIMIT_S:
        yield Finding.of("clocks", Message("Clocks of the computers"))
        return
    text = Message(
        "The clock of {node} differs from this computer's by {offset_s:.1f} s.",
        node=node_title(node),
        offset_s=abs(offset_s),
        details=facts.software[node].host if node in facts.software else "",
    )
    advice = Message("Set the clocks of both computers, but not during a survey: install chrony.")
    yield Finding.of("clocks", text, CLOCK_WRONG, mild=True, advice=advice)


def _endstop(axis_id: AxisId, position: AxisReport, seen: Endstop) -> Finding:
    axis, fault, advice = axis_id.value.upper(), None, None
    if seen.pressed and position.homed and position.coordinate > ENDSTOP_REACH_MM:
        text = Message(
            "The endstop of the {axis} axis is closed at {coordinate_mm:.0f} mm.",
            axis=axis,
            coordinate_mm=position.coordinate,
        )
        fault = ENDSTOP
    elif seen.changes:
        text = Message("The endstop of the {axis} axis works: its state has changed.", axis=axis)
    elif not seen.pressed:
        text = Message("The endstop of the {axis} axis is open.", axis=axis)
    elif position.homed:
        text = Message("The endstop of the {axis} axis is closed, at its zero.", axis=axis)
    else:
        text = Message("The endstop of the {axis} axis is closed; it is not homed.", axis=axis)
        fault = ENDSTOP.as_warning()
        advice = Message(
            "See whether the carriage presses it. If not, switch off the motors' power, and check "
            "switch and cable."
        )
    return Finding.of(f"endstop_{axis_id.value}", text, fault, advice=advice)


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


UNHEARD: Tuple[Check, ...] = (check_contact, check_unheard)
CHECKS: Tuple[Check, ...] = (
    check_contact,
    check_configuration,
    check_versions,
    check_parts,
    check_analyzer,
    check_disk,
    check_height,
    check_endstops,
    check_clocks,
)
