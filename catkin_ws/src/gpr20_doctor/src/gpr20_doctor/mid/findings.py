"""All findings about the robot and this computer, and what they mean together."""

from __future__ import annotations

from typing import Iterable, List, Optional, Tuple

from gpr20_common.message import Message
from gpr20_doctor.mid import machine_checks, robot_checks
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.robot_facts import RobotFacts

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
        for check in robot_checks.CHECKS if robot.nodes else robot_checks.UNHEARD:
            found.extend(check(robot))
    if machine is not None:
        for machine_check in machine_checks.CHECKS:
            found.extend(machine_check(machine))
    return worst_first(found)


def worst_first(found: Iterable[Finding]) -> Tuple[Finding, ...]:
    """Return findings by their level; those of one level keep their order."""
    by_badness = {Level.SKIPPED: -1}
    return tuple(sorted(found, key=lambda one: by_badness.get(one.level, one.level), reverse=True))


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
        "{faults} faults, {warnings} warnings, {unknown} unknown, {good} good, {skipped} skipped",
        faults=levels.count(Level.FAULT),
        warnings=levels.count(Level.WARNING),
        unknown=levels.count(Level.UNKNOWN),
        good=levels.count(Level.OK),
        skipped=levels.count(Level.SKIPPED),
    )
