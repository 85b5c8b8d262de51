"""What is wrong with the robot, judged from what it reports; and what to do about it.

Each check is a function from the known facts to findings. To add one, write it and list it in
CHECKS.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Callable, Iterable, Iterator, List, Mapping, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_user_interface.mid.events import HealthLevel, NodeHealth
from gpr20_user_interface.mid.remedies import find_remedy
from gpr20_user_interface.mid.robot_health import ANALYZER
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.titles import node_title

# A node reports once a second; a window that has just opened has not heard all of them [s].
STARTING_S = 5.0
LOW_DISK_GB = 5.0
FULL_DISK_GB = 0.5
MEGABYTES_PER_GIGABYTE = 1000.0
# A message is under way for some of it; times of traces are wrong by the rest [s].
CLOCK_OFFSET_LIMIT_S = 1.0
# An endstop is at the zero of its axis: farther away than this it cannot be pressed [mm].
ENDSTOP_REACH_MM = 5.0
# What an axis that is not homed says; it is homed at the start of a survey.
NOT_HOMED = Message("not homed")
# What the VNA's driver says between two surveys.
NOT_CONNECTED = Message("not connected")

RESTART = Message("Wait 10 s: it restarts by itself. If it does not come back, restart the robot.")


@dataclass(frozen=True)
class Facts:
    """What is known about the robot.

    Attributes:
        snapshot: What the window shows.
        configuration_problem: Why the robot's configuration is not known; None if it is.
        clock_offsets_s: How far the clock of each node's computer is behind this one [s].
        listening_s: For how long the window has listened to the robot [s].
    """

    snapshot: Snapshot
    configuration_problem: Optional[Message] = None
    clock_offsets_s: Mapping[str, float] = field(default_factory=dict)
    listening_s: float = math.inf


@dataclass(frozen=True)
class Finding:
    """The result of a check.

    Attributes:
        level: OK, WARN or ERROR.
        text: What was found, in one sentence.
        remedy: What to do; None: nothing, or the sentence says it.
    """

    level: HealthLevel
    text: Message
    remedy: Optional[Message] = None


Check = Callable[[Facts], Iterable[Finding]]


def findings(facts: Facts) -> Tuple[Finding, ...]:
    """Return the results of all checks, the worst first."""
    found: List[Finding] = []
    for check in CHECKS:
        found.extend(check(facts))
    return tuple(sorted(found, key=lambda one: one.level, reverse=True))


def check_contact(facts: Facts) -> Iterator[Finding]:
    """Judge the contact with the ROS master and the main control."""
    if not facts.snapshot.master_alive:
        yield Finding(
            HealthLevel.ERROR,
            Message("The ROS master does not answer."),
            Message(
                "Check that the robot's software runs and, with two computers, the cable between "
                "them."
            ),
        )
    if not facts.snapshot.control_alive:
        yield Finding(
            HealthLevel.ERROR,
            Message("There is no contact with the main control."),
            Message(
                "Wait 10 s: it restarts by itself. If it does not come back, restart the robot."
            ),
        )
    if facts.snapshot.master_alive and facts.snapshot.control_alive:
        yield Finding(HealthLevel.OK, Message("Contact with the robot"))


def check_configuration(facts: Facts) -> Iterator[Finding]:
    """Judge what the nodes say about themselves."""
    if facts.configuration_problem is not None:
        yield Finding(
            HealthLevel.ERROR,
            Message("No survey can start: {reason}", reason=facts.configuration_problem),
        )
    elif facts.snapshot.travel is None:
        yield Finding(
            HealthLevel.WARN,
            Message("The robot's configuration is not known yet."),
            Message("Wait until all parts of the robot have started."),
        )
    else:
        yield Finding(HealthLevel.OK, Message("Configuration of the robot"))
    if facts.snapshot.simulated:
        yield Finding(
            HealthLevel.WARN,
            Message("The robot is simulated: its data show no real ground."),
            Message("For the real robot launch with robot:=gpr20."),
        )


def check_parts(facts: Facts) -> Iterator[Finding]:
    """Judge each node by its own report."""
    for node in facts.snapshot.health.nodes:
        yield _part(node, facts.listening_s)


def check_disk(facts: Facts) -> Iterator[Finding]:
    """Judge the space for recordings."""
    free_mb = facts.snapshot.health.free_disk_mb
    if free_mb is None:
        yield Finding(
            HealthLevel.WARN,
            Message("The free disk space is not known."),
            Message("It is known when the storage reports."),
        )
        return
    free_gb = free_mb / MEGABYTES_PER_GIGABYTE
    level = HealthLevel.OK
    remedy: Optional[Message] = None
    if free_gb < LOW_DISK_GB:
        level = HealthLevel.ERROR if free_gb < FULL_DISK_GB else HealthLevel.WARN
        remedy = Message("Copy surveys to another computer, check the copies, then delete them.")
    yield Finding(level, Message("Disk: {free_gb:.1f} GB free", free_gb=free_gb), remedy)


def check_calibration(facts: Facts) -> Iterator[Finding]:
    """Judge the calibration of the VNA when it was last read."""
    calibration = facts.snapshot.health.calibration
    level, text, remedy = CALIBRATIONS.get(
        calibration, (HealthLevel.WARN, verbatim(calibration), CALIBRATE)
    )
    yield Finding(level, text, remedy)


def check_endstops(facts: Facts) -> Iterator[Finding]:
    """Find an endstop that is closed where its axis cannot press it."""
    for axis in ("x", "y"):
        node = facts.snapshot.health.node(f"{axis}_axis/axis_driver")
        if node is None or node.level is HealthLevel.STALE:
            continue
        values = node.values
        if values.get("endstop") != "pressed" or values.get("homed") != "True":
            continue
        coordinate_mm = _number(values.get("coordinate [mm]", ""))
        if coordinate_mm > ENDSTOP_REACH_MM:
            yield Finding(
                HealthLevel.ERROR,
                Message(
                    "The endstop of the {axis} axis is closed at {coordinate_mm:.0f} mm.",
                    axis=axis.upper(),
                    coordinate_mm=coordinate_mm,
                ),
                Message("Check the switch and its cable for a short circuit."),
            )


def check_clocks(facts: Facts) -> Iterator[Finding]:
    """Compare the clocks of the computers."""
    worst = max(facts.clock_offsets_s.items(), key=lambda one: abs(one[1]), default=None)
    if worst is None:
        return
    node, offset_s = worst
    if abs(offset_s) <= CLOCK_OFFSET_LIMIT_S:
        yield Finding(HealthLevel.OK, Message("Clocks of the computers"))
        return
    yield Finding(
        HealthLevel.WARN,
        Message(
            "The clock of {node} differs from this computer's by {offset_s:.1f} s.",
            node=node_title(node),
            offset_s=abs(offset_s),
        ),
        Message("Set the clocks of both computers, for example with chrony."),
    )


def _number(text: str) -> float:
    """Return the number of a report; NaN, which fails every comparison, if it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _part(node: NodeHealth, listening_s: float) -> Finding:
    name = node_title(node.name)
    if node.level is HealthLevel.OK:
        return Finding(HealthLevel.OK, name)
    if node.level is HealthLevel.STALE:
        level = HealthLevel.ERROR if listening_s > STARTING_S else HealthLevel.WARN
        return Finding(level, Message("{name} does not report.", name=name), RESTART)
    remedy = find_remedy(node.message) if node.level is HealthLevel.ERROR else None
    if node.message == NOT_HOMED:
        remedy = Message("A survey homes it; or home it here.")
    elif node.name == ANALYZER and node.message == NOT_CONNECTED:
        remedy = Message("A survey connects it; or test the VNA here.")
    return Finding(node.level, Message("{name}: {state}", name=name, state=node.message), remedy)


CALIBRATE = Message("Calibrate the VNA with the cables of the survey.")
CALIBRATIONS = {
    "": (
        HealthLevel.WARN,
        Message("The calibration of the VNA has not been read yet."),
        Message("Test the VNA here."),
    ),
    "NONE": (HealthLevel.ERROR, Message("The VNA has no calibration."), CALIBRATE),
    "HIGH": (HealthLevel.OK, Message("Calibration of the VNA: high accuracy"), None),
    "MODERATE_POWER": (
        HealthLevel.WARN,
        Message("The VNA's power level has changed since its calibration."),
        CALIBRATE,
    ),
    "MODERATE_TEMPERATURE": (
        HealthLevel.WARN,
        Message("The VNA's temperature has changed by more than 5 °C since its calibration."),
        CALIBRATE,
    ),
    "LOW": (
        HealthLevel.WARN,
        Message("The VNA's temperature has changed by more than 10 °C since its calibration."),
        CALIBRATE,
    ),
    "NOT_REPORTED": (
        HealthLevel.WARN,
        Message("This VNA does not report its calibration."),
        Message("Make sure that it is calibrated."),
    ),
}
CHECKS: Tuple[Check, ...] = (
    check_contact,
    check_configuration,
    check_parts,
    check_calibration,
    check_disk,
    check_endstops,
    check_clocks,
)
