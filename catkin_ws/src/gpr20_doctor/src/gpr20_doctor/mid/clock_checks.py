"""Checks of the clocks of this computer and of the robot's others."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path
from typing import Iterator

from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import Machine
from gpr20_doctor.mid.node_health import node_title
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_survey.faults import CLOCK_WRONG

# A clock that starts at the last date that it knows is days behind; a time zone is not.
BEHIND_LIMIT_S = 86400.0
# A message is under way for some of it; times of traces are wrong by the rest [s].
OFFSET_LIMIT_S = 1.0
ZONES = "usr/share/zoneinfo"
# Such as CET-1CEST, without a file (tzset(3)).
_RULE = re.compile(r"([A-Za-z]{3,}|<[\w+-]+>)[+-]?\d.*")


def check_date(machine: Machine) -> Iterator[Finding]:
    """Find a clock that cannot be right, and a time zone that is none."""
    behind_s = Path(__file__).stat().st_mtime - time.time()
    if behind_s > BEHIND_LIMIT_S:
        text = Message(
            "This computer's clock is {days:.0f} days before the date of the installed software.",
            days=behind_s / 86400.0,
        )
        advice = Message("Unless a survey runs, set the clock: sudo date -s '2026-07-31 14:00'")
        yield Finding.of("date", text, CLOCK_WRONG, mild=True, advice=advice)
    zone, file = machine.environment.get("TZ", "").lstrip(":"), machine.root / "etc/localtime"
    if zone:
        known = (machine.root / ZONES / zone).is_file() or bool(_RULE.fullmatch(zone))
        advice = Message("Run: unset TZ. If it is found again, remove TZ where it is set.")
    else:
        # Without the file the zone is UTC; a link that leads nowhere is a mistake.
        known = file.exists() or not os.path.islink(str(file))
        zone = "" if known else os.readlink(str(file))
        advice = Message("Run: sudo timedatectl set-timezone Europe/Madrid, or another zone.")
    if not known:
        text = Message("There is no time zone {zone}: local times are wrong.", zone=zone)
        yield Finding.of("zone", text, CLOCK_WRONG, mild=True, advice=advice)


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
