"""All checks of the computer on which the doctor runs.

Each is a function from a `Machine` to findings. To add one, write it in the module of its subject
and list it here.
"""

from __future__ import annotations

from functools import partial
from typing import Callable, Iterable, List, Mapping

from gpr20_common.errors import os_reason
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.node_facts import own_software
from gpr20_doctor.low.programs import FAILURES, in_time
from gpr20_doctor.mid import (
    clock_checks,
    disk_checks,
    hardware_checks,
    network_checks,
    process_checks,
    software_checks,
)
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine import Machine, MachineReport

Check = Callable[[Machine], Iterable[Finding]]
# A check that takes longer hangs, such as on a disk; that of the configuration has its own limit.
LIMIT_S, LONG_LIMIT_S = 6.0, 70.0
# Each with the name of its findings.
CHECKS: Mapping[str, Check] = {
    "config_files": software_checks.check_configuration,
    "edited": software_checks.check_edited,
    "packages": software_checks.check_packages,
    "launch": process_checks.check_launch,
    "watchdog": process_checks.check_watchdog,
    "memory": process_checks.check_memory,
    "addresses": network_checks.check_addresses,
    "firewall": network_checks.check_firewall,
    "hardware": hardware_checks.check_hardware,
    "power": hardware_checks.check_power,
    "volumes": disk_checks.check_volumes,
    "date": clock_checks.check_date,
}


def examine(machine: Machine) -> MachineReport:
    """Return what the checks of a computer find; one that fails is UNKNOWN, with the reason."""
    found: List[Finding] = []
    for name, check in CHECKS.items():
        limit_s = LONG_LIMIT_S if check is software_checks.check_configuration else LIMIT_S
        try:
            found.extend(in_time(partial(_list, check, machine), limit_s))
        except FAILURES as error:
            reason = os_reason(error) if isinstance(error, OSError) else verbatim(str(error))
            text = Message(
                "The check {check} was not possible: {reason}", check=name, reason=reason
            )
            found.append(Finding(name, Level.UNKNOWN, text, BY_HAND))
    return MachineReport(tuple(found), own_software(), machine)


def _list(check: Check, machine: Machine) -> List[Finding]:
    return list(check(machine))


BY_HAND = Message("Look by hand: docs/doctor.md says how.")
