"""All findings about the robot and this computer: what they mean together, text and JSON."""

from __future__ import annotations

import json
from typing import Any, Dict, Iterable, Iterator, List, Optional, Tuple

from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_doctor.mid import machine_checks, robot_checks
from gpr20_doctor.mid.contact_checks import check_installed
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.place import advised
from gpr20_doctor.mid.robot_facts import RobotFacts

FILES = "config_files"
BETWEEN = "; "
LEVEL_WIDTH = 12
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


def lines(found: Tuple[Finding, ...], catalogue: Catalogue) -> Iterator[str]:
    """Yield the lines of a terminal: level and sentence, the remedy below, counts at the end."""
    for one in found:
        level = catalogue.text(one.level.title)
        yield f"{level:{LEVEL_WIDTH}}{_with_details(one.text, catalogue)}"
        if one.remedy is not None:
            yield f"{'':{LEVEL_WIDTH}}-> {catalogue.text(one.remedy)}"
    yield catalogue.text(summary(found))


def as_json(found: Tuple[Finding, ...], catalogue: Catalogue) -> str:
    """Return findings as one JSON object."""
    record: Dict[str, Any] = {
        "status": exit_status(found),
        "findings": [
            {
                "check": one.check,
                "fault_code": one.text.fault_code,
                "level": one.level.name,
                "text": catalogue.text(one.text),
                "details": BETWEEN.join(one.text.all_details),
                "remedy": "" if one.remedy is None else catalogue.text(one.remedy),
            }
            for one in found
        ],
    }
    return json.dumps(record, indent=2)


def _with_details(message: Message, catalogue: Catalogue) -> str:
    details = BETWEEN.join(message.all_details)
    text = catalogue.text(message)
    return f"{text} ({details})" if details else text
