"""All checks of the computer, and what all findings mean together, as text and JSON.

A check of the computer is a function from a `Machine` to findings. To add one, write it in the
module of its subject and list it here.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Tuple

from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import os_reason
from gpr20_common.faults import DISK_FULL
from gpr20_common.message import BETWEEN_SENTENCES, Message, verbatim
from gpr20_common.mid.node_facts import own_software
from gpr20_doctor.low.processes import FAILURES, in_time
from gpr20_doctor.mid import computer_checks, network_checks, robot_checks, software_checks
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine import Machine, MachineReport
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_survey.plan.robot_description import STORAGE

SPACE = "data_disk"
LEVEL_WIDTH = 12
# Exit status of each level.
STATUS = (0, 0, 1, 1, 2)
BY_HAND = Message("Look by hand: docs/doctor.md says how.")
SPACE_AGAIN = Message(
    "The disk has space again: press RESUME. Without a survey nothing is to be done."
)

# A generator: it begins when its findings are asked for, with a limit.
Check = Callable[[Machine], Iterator[Finding]]
# A check that takes longer hangs, such as on a disk; that of the configuration has its own limit.
LIMIT_S, LONG_LIMIT_S = 6.0, 70.0
# Each with the name of its findings.
CHECKS: Mapping[str, Check] = {
    "config_files": software_checks.check_configuration,
    "edited": software_checks.check_edited,
    "packages": software_checks.check_packages,
    "launch": software_checks.check_launch,
    "watchdog": software_checks.check_watchdog,
    "memory": computer_checks.check_memory,
    "addresses": network_checks.check_addresses,
    "firewall": network_checks.check_firewall,
    "hardware": computer_checks.check_hardware,
    "power": computer_checks.check_power,
    "volumes": computer_checks.check_volumes,
    "date": computer_checks.check_date,
}


def examine(machine: Machine) -> MachineReport:
    """Return what the checks of a computer find; one that fails is UNKNOWN, with the reason."""
    found: List[Finding] = []
    for name, check in CHECKS.items():
        limit_s = LONG_LIMIT_S if check is software_checks.check_configuration else LIMIT_S
        try:
            found.extend(in_time(partial(list, check(machine)), limit_s))
        except FAILURES as error:
            reason = os_reason(error) if isinstance(error, OSError) else verbatim(str(error))
            text = Message(
                "The check {check} was not possible: {reason}", check=name, reason=reason
            )
            found.append(Finding(name, Level.UNKNOWN, text, BY_HAND))
    return MachineReport(tuple(found), own_software(), machine)


def findings(robot: RobotFacts, machine: Optional[MachineReport]) -> Tuple[Finding, ...]:
    """Return the results of all checks, the worst first.

    Args:
        robot: What the nodes report.
        machine: What was found about this computer; None: not asked for.
    """
    here = Machine() if machine is None else machine.machine
    found: List[Finding] = [] if machine is None else [*machine.found]
    for check in robot_checks.CHECKS:
        found.extend(check(robot, here))
    found.extend(software_checks.check_versions(robot, machine))
    has_space = any(one.check == SPACE and one.level is Level.OK for one in found)
    for number, one in enumerate(found):
        # The storage repeats its last failure until it stores again.
        if has_space and (one.check, one.text.fault_code) == (STORAGE, DISK_FULL.code):
            found[number] = replace(one, remedy=SPACE_AGAIN)
    return tuple(sorted(found, key=lambda one: one.level, reverse=True))


def exit_status(found: Iterable[Finding]) -> int:
    """Return what a program says with its exit status."""
    return STATUS[max((one.level for one in found), default=Level.UNKNOWN)]


def summary(found: Tuple[Finding, ...]) -> Message:
    """Return how many findings have each level."""
    levels = [one.level for one in found]
    return Message(
        "faults: {faults}, warnings: {warnings}, unknown: {unknown}, notes: {notes}, good: {good}",
        faults=levels.count(Level.FAULT),
        warnings=levels.count(Level.WARNING),
        unknown=levels.count(Level.UNKNOWN),
        good=levels.count(Level.OK),
        notes=levels.count(Level.NOTE),
    )


def lines(found: Tuple[Finding, ...], catalogue: Catalogue) -> Iterator[str]:
    """Yield the lines of a terminal: level and sentence, the remedy below, counts at the end."""
    for one in found:
        details = BETWEEN_SENTENCES.join(one.text.all_details)
        text = catalogue.text(one.text) + (f" ({details})" if details else "")
        yield f"{catalogue.text(one.level.title):{LEVEL_WIDTH}}{text}"
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
                "details": BETWEEN_SENTENCES.join(one.text.all_details),
                "remedy": "" if one.remedy is None else catalogue.text(one.remedy),
            }
            for one in found
        ],
    }
    return json.dumps(record, indent=2)
