"""All findings about the robot and this computer, and what they mean together."""

from __future__ import annotations

from typing import Iterable, List, Optional, Tuple

from gpr20_common.message import Message
from gpr20_doctor.mid import machine_checks, robot_checks
from gpr20_doctor.mid.advice import advised
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_doctor.mid.version_checks import check_installed

FILES = "config_files"
GOOD, DOUBTFUL, BAD = 0, 1, 2
"""Exit status: everything is good; a warning or something unknown; a fault."""


def findings(robot: Optional[RobotFacts], machine: Optional[MachineFacts]) -> Tuple[Finding, ...]:
    """Return the results of all checks, the worst first.

    Args:
        robot: What the nodes report; None: not asked for.
        machine: What is known about this computer; None: not asked for.
    """
    found: List[Finding] = []
    if robot is not None:
        for check in robot_checks.UNHEARD if robot.unheard else robot_checks.CHECKS:
            found.extend(check(robot))
    if machine is not None:
        for machine_check in machine_checks.CHECKS:
            found.extend(machine_check(machine))
    if robot is not None and machine is not None:
        found.extend(check_installed(robot, machine.software))
    if any(one.check == "disk" and one.level is not Level.UNKNOWN for one in found):
        found = [one for one in found if one.check != "data_disk"]
    # The check of the files also looks at the data folder, whose own check says more.
    known = {one.text.fault_code for one in found if one.check == "data_folder"} - {""}
    found = [one for one in found if one.check != FILES or one.text.fault_code not in known]
    if machine is not None:
        found = [advised(one, machine.place) for one in found]
    return tuple(sorted(found, key=lambda one: one.level, reverse=True))


def exit_status(found: Iterable[Finding]) -> int:
    """Return what a program says with its exit status."""
    worst = max((one.level for one in found), default=Level.UNKNOWN)
    if worst is Level.FAULT:
        return BAD
    return DOUBTFUL if worst in (Level.WARNING, Level.UNKNOWN) else GOOD


def summary(found: Tuple[Finding, ...]) -> Message:
    """Return how many findings have each level."""
    levels = [one.level for one in found]
    return Message(
        "{faults} faults, {warnings} warnings, {unknown} unknown, {notes} notes, {good} good",
        faults=levels.count(Level.FAULT),
        warnings=levels.count(Level.WARNING),
        unknown=levels.count(Level.UNKNOWN),
        good=levels.count(Level.OK),
        notes=levels.count(Level.NOTE),
    )
