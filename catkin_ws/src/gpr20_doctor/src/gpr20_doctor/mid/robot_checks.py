"""Checks of what the robot's nodes report.

Each check is a function from the facts to findings. To add one, write it and list it in CHECKS.
"""

from __future__ import annotations

import math
from typing import Callable, Iterable, Iterator, Tuple

from gpr20_common.message import Message
from gpr20_doctor.mid.analyzer_checks import check_analyzer
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth, axis_node
from gpr20_doctor.mid.remedies import CHECK_CONFIGURATION, RESTART_ROBOT, find_remedy
from gpr20_doctor.mid.robot_facts import EndstopSeen, RobotFacts
from gpr20_doctor.mid.titles import node_title
from gpr20_doctor.mid.version_checks import check_versions
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import ANALYZER, HEIGHT_SENSOR, STORAGE

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
# What an axis that is not homed says; it is homed at the start of a survey.
NOT_HOMED = Message("not homed")
# What the VNA's driver says between two surveys.
NOT_CONNECTED = Message("not connected")
# What the height sensor says until it is asked.
NO_HEIGHT = Message("no height measured yet")

RESTART = Message("Wait 10 s: it restarts by itself. If it does not come back, restart the robot.")
LOOK = Message("Look at the details of this part on STATUS.")
CHECK_SWITCH = Message("Check the switch and its cable for a short circuit.")
MAKE_SPACE = Message("Copy surveys to another computer, check the copies, then delete them.")

Check = Callable[[RobotFacts], Iterable[Finding]]


def check_contact(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the contact with the ROS master and the main control."""
    if not facts.master_alive:
        yield Finding(
            "master",
            Level.FAULT,
            Message("The ROS master does not answer.", details=facts.master),
            Message(
                "Check that the robot's software runs and, with two computers, the cable between "
                "them."
            ),
        )
    elif facts.control_alive:
        yield Finding("master", Level.OK, Message("Contact with the robot"))
    if not facts.control_alive and not facts.unheard:
        yield Finding(
            "control",
            Level.FAULT,
            Message("There is no contact with the main control."),
            RESTART,
        )


def check_unheard(facts: RobotFacts) -> Iterator[Finding]:
    """Say what nobody can tell while no node can be heard."""
    yield Finding(
        "parts",
        Level.UNKNOWN,
        Message("Axes, height sensor, VNA, storage and versions: not known without the master."),
        Message("Start the robot's software, then run gpr20 doctor again."),
    )


def check_configuration(facts: RobotFacts) -> Iterator[Finding]:
    """Judge what the nodes say about themselves."""
    if facts.configuration_problem is not None:
        reason = facts.configuration_problem
        yield Finding(
            "configuration",
            Level.FAULT,
            Message("No survey can start: {reason}", reason=reason),
            find_remedy(reason) or CHECK_CONFIGURATION,
        )
    elif not facts.configured:
        yield Finding(
            "configuration",
            Level.UNKNOWN,
            Message("The robot's configuration is not known yet."),
            Message("Wait until all parts of the robot have started."),
        )
    else:
        yield Finding("configuration", Level.OK, Message("Configuration of the robot"))
    if facts.simulated:
        yield Finding(
            "simulated",
            Level.NOTE,
            Message("The robot is simulated: its data show no real ground."),
            Message("For the real robot launch with robot:=gpr20."),
        )


def check_parts(facts: RobotFacts) -> Iterator[Finding]:
    """Judge each node by its own report."""
    return (_part(node, facts.listening_s) for node in facts.nodes)


def check_disk(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the space for recordings."""
    free_mb = number_of(facts.value(STORAGE, "free disk [MB]"))
    if math.isnan(free_mb):
        yield Finding(
            "disk",
            Level.UNKNOWN,
            Message("The free disk space is not known."),
            Message("It is known when the storage reports."),
        )
    else:
        yield disk_space("disk", free_mb / MEGABYTES_PER_GIGABYTE)


def disk_space(check: str, free_gb: float) -> Finding:
    """Judge the space on the disk of the surveys [GB]."""
    text = Message("Disk: {free_gb:.1f} GB free", free_gb=free_gb)
    if free_gb >= LOW_DISK_GB:
        return Finding(check, Level.OK, text)
    level = Level.FAULT if free_gb < FULL_DISK_GB else Level.WARNING
    return Finding(check, level, text, MAKE_SPACE)


def check_height(facts: RobotFacts) -> Iterator[Finding]:
    """Judge whether the last height can be one of the antennas."""
    height_m = number_of(facts.value(HEIGHT_SENSOR, "height [m]"))
    if math.isnan(height_m):
        return  # the part itself says why
    lowest_m, highest_m = USUAL_HEIGHT_M
    if lowest_m <= height_m <= highest_m:
        yield Finding(
            "height",
            Level.OK,
            Message("Height of the antennas: {height_m:.3f} m", height_m=height_m),
        )
        return
    yield Finding(
        "height",
        Level.WARNING,
        Message(
            "The height of the antennas is {height_m:.3f} m; expected {lowest_m:g} to "
            "{highest_m:g} m.",
            height_m=height_m,
            lowest_m=lowest_m,
            highest_m=highest_m,
        ),
        Message("Look below the sensor, and check the offset in height.yaml."),
    )


def check_endstops(facts: RobotFacts) -> Iterator[Finding]:
    """Judge the endstops, and find one that is closed where its axis cannot press it."""
    for axis_id in (AxisId.X, AxisId.Y):
        node = facts.node(axis_node(axis_id))
        if node is None:
            continue
        seen = facts.endstops.get(axis_id)
        if seen is None and node.values.get("endstop") in ("pressed", "open"):
            seen = EndstopSeen(node.values["endstop"] == "pressed")
        if seen is not None:
            yield _endstop(axis_id, node, seen)


def check_clocks(facts: RobotFacts) -> Iterator[Finding]:
    """Compare the clocks of the computers."""
    worst = max(facts.clock_offsets_s.items(), key=lambda one: abs(one[1]), default=None)
    if worst is None:
        return
    node, offset_s = worst
    if abs(offset_s) <= CLOCK_OFFSET_LIMIT_S:
        yield Finding("clocks", Level.OK, Message("Clocks of the computers"))
        return
    yield Finding(
        "clocks",
        Level.WARNING,
        Message(
            "The clock of {node} differs from this computer's by {offset_s:.1f} s.",
            node=node_title(node),
            offset_s=abs(offset_s),
        ),
        Message("Set the clocks of both computers, for example with chrony."),
    )


def number_of(text: str) -> float:
    """Return the number of a report; NaN, which fails every comparison, if it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _endstop(axis_id: AxisId, node: NodeHealth, seen: EndstopSeen) -> Finding:
    check, axis = f"endstop_{axis_id.value}", axis_id.value.upper()
    coordinate_mm = number_of(node.values.get("coordinate [mm]", ""))
    homed = node.values.get("homed") == "True"
    if seen.pressed and homed and coordinate_mm > ENDSTOP_REACH_MM:
        text = Message(
            "The endstop of the {axis} axis is closed at {coordinate_mm:.0f} mm.",
            axis=axis,
            coordinate_mm=coordinate_mm,
        )
        return Finding(check, Level.FAULT, text, CHECK_SWITCH)
    if seen.changes:
        text = Message("The endstop of the {axis} axis works: its state has changed.", axis=axis)
        return Finding(check, Level.OK, text)
    if not seen.pressed:
        text = Message("The endstop of the {axis} axis is open.", axis=axis)
        return Finding(check, Level.OK, text)
    if homed:
        text = Message("The endstop of the {axis} axis is closed, at its zero.", axis=axis)
        return Finding(check, Level.OK, text)
    text = Message("The endstop of the {axis} axis is closed; it is not homed.", axis=axis)
    remedy = Message("See whether the carriage presses it. If not, check switch and cable.")
    return Finding(check, Level.WARNING, text, remedy)


def _part(node: NodeHealth, listening_s: float) -> Finding:
    name = node_title(node.name)
    if node.level is HealthLevel.OK:
        return Finding(node.name, Level.OK, name)
    if node.level is HealthLevel.STALE:
        level = Level.FAULT if listening_s > STARTING_S else Level.UNKNOWN
        return Finding(node.name, level, Message("{name} does not report.", name=name), RESTART)
    text = Message("{name}: {state}", name=name, state=node.message)
    if node.level is HealthLevel.ERROR:
        return Finding(node.name, Level.FAULT, text, find_remedy(node.message) or RESTART_ROBOT)
    return _warned_part(node, text)


def _warned_part(node: NodeHealth, text: Message) -> Finding:
    if node.message == NOT_HOMED:
        remedy = Message("A survey homes it; or home it on SERVICE.")
        return Finding(node.name, Level.NOTE, text, remedy)
    if node.name == ANALYZER and node.message == NOT_CONNECTED:
        remedy = Message("A survey connects it; or test the VNA on SERVICE.")
        return Finding(node.name, Level.NOTE, text, remedy)
    if node.message == NO_HEIGHT:
        remedy = Message("A survey measures it; or measure it on SERVICE.")
        return Finding(node.name, Level.UNKNOWN, text, remedy)
    return Finding(node.name, Level.WARNING, text, find_remedy(node.message) or LOOK)


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
