"""Checks of this computer: disks, memory, the pins and bus of the robot, the supply, the clock.

Whether the folder of the surveys is the right one, the check of the configuration says.
"""

from __future__ import annotations

import getpass
import importlib.util
import os
import re
import time
from pathlib import Path
from typing import Dict, Iterator, Mapping

from gpr20_common.faults import DISK_FULL, DISK_REFUSES, NOT_SET_UP, OVERLOADED
from gpr20_common.low.yaml_file import state_folder
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_doctor import faults
from gpr20_doctor.low.processes import answer_of
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import Machine
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.folder.data_folder import existing_folder, file_system_of
from gpr20_survey.plan.robot_description import HEIGHT_SENSOR

MB, GB, BYTES_PER_KB = 1e6, 1e9, 1024
# Below them the system begins to end programs [bytes].
LOW_MEMORY, NO_MEMORY = 200e6, 80e6
# Of the disk of the surveys, and of the others, which take the logs of a day [bytes]; below the
# second of each, programs fail when they write.
DATA_SPACE, OTHER_SPACE = (5 * GB, 0.5 * GB), (200 * MB, 20 * MB)
FEW_FILES = 2000
# Bits of the answer of the firmware: low voltage now and before, slowed down now.
LOW_NOW, SLOW_NOW, LOW_BEFORE = 1 << 0, 1 << 2, 1 << 16
GPIO_FILES = ("dev/gpiomem", "dev/gpiochip*")
# A clock that starts at the last date that it knows is days behind; a time zone is not.
BEHIND_LIMIT_S = 86400.0
# Such as CET-1CEST, without a file (tzset(3)).
_RULE = re.compile(r"([A-Za-z]{3,}|<[\w+-]+>)[+-]?\d.*")


def check_volumes(machine: Machine) -> Iterator[Finding]:
    """Judge each file system that the robot writes to, once, and whether this user may write."""
    own = list(filter(None, (machine.data, machine.log, state_folder(machine.environment))))
    devices = set()
    for folder in (*own, machine.root, machine.root / "tmp", machine.root / "var/log"):
        existing = existing_folder(folder)
        device, allowed = existing.stat().st_dev, os.access(str(existing), os.W_OK)
        refused = folder in own and not allowed and not file_system_of(existing).read_only
        if refused:
            yield _refused(printable(existing))
        elif device not in devices:
            is_data = folder == machine.data
            check, limits = ("data_disk", DATA_SPACE) if is_data else ("volumes", OTHER_SPACE)
            yield _volume(check, folder, existing, *limits)
        devices.add(device)


def _refused(folder: str) -> Finding:
    text = Message("This user may not write into {folder}.", folder=folder)
    advice = Message(
        'If the robot runs as this user, run: sudo chown "$USER" {folder}. If it has '
        "services, run: gpr20-run doctor",
        folder=folder,
    )
    return Finding.of("volumes", text, DISK_REFUSES, mild=True, advice=advice)


def _volume(check: str, folder: Path, existing: Path, low: float, none: float) -> Finding:
    system, numbers = file_system_of(existing), os.statvfs(str(existing))
    free, files = numbers.f_bavail * numbers.f_frsize, numbers.f_favail
    names = {"point": printable(system.mount_point), "folder": printable(folder)}
    if system.read_only:
        text = Message("The file system {point} is read-only; {folder} is on it.", **names)
        advice = Message(
            "Copy what must not be lost from {point}. Then run: sudo mount -o remount,rw {point}. "
            "If that fails or it happens again, replace the card or disk.",
            **names,
        )
        return Finding.of(check, text, DISK_REFUSES, advice=advice)
    text = Message(
        "The file system {point} has {free_mb:.0f} MB left; {folder} is on it.",
        free_mb=free / MB,
        **names,
    )
    full, mild = free < low, free >= none
    if not full and numbers.f_files and files < FEW_FILES:
        text = Message(
            "The file system {point} can hold only {count} more files; {folder} is on it.",
            count=files,
            **names,
        )
        full, mild = True, False
    advice = Message(
        "Make space on {point}, but copy surveys before you delete them. To see what is large, "
        "run: sudo du -xh {point} | sort -h | tail",
        **names,
    )
    return Finding.of(check, text, DISK_FULL if full else None, mild, advice)


def check_hardware(machine: Machine) -> Iterator[Finding]:
    """Judge everything that the drivers of axes and height sensor need."""
    if not machine.drives_hardware:
        return
    yield _spi(machine)
    if any(_has_pins(machine, axis) for axis in AxisId):
        yield _gpio(machine.root)


def _has_pins(machine: Machine, axis: AxisId) -> bool:
    """Return whether an axis is moved by pins, and not by another controller."""
    own = machine.configured("axes.yaml", axis.value)
    return not (isinstance(own, Mapping) and own.get("controller"))


def _spi(machine: Machine) -> Finding:
    bus, device = (
        machine.value(HEIGHT_SENSOR, "height.yaml", key) or 0 for key in ("spi_bus", "spi_device")
    )
    path = machine.root / f"dev/spidev{bus}.{device}"
    if not path.exists():
        text = Message("The SPI bus is off: there is no {path}.", path=str(path))
        advice = Message("Run: sudo raspi-config nonint do_spi 0. Then restart the computer.")
        return Finding.of("spi", text, NOT_SET_UP, advice=advice)
    if not _usable(path):
        text = Message("The SPI bus {path} cannot be read and written.", path=str(path))
        return Finding.of("spi", text, NOT_SET_UP, advice=_join("spi"))
    return Finding.of("spi", Message("SPI bus {path}", path=str(path)))


def _gpio(root: Path) -> Finding:
    devices = [path for pattern in GPIO_FILES for path in sorted(root.glob(pattern))]
    if importlib.util.find_spec("RPi") is None:
        text = Message("The library RPi.GPIO for the pins is not installed.")
        advice = Message("Run: scripts/setup.sh --robot")
        return Finding.of("gpio", text, NOT_SET_UP, advice=advice)
    if not any(map(_usable, devices)):
        text = Message("The pins cannot be used: no access to /dev/gpiomem or /dev/gpiochip.")
        return Finding.of("gpio", text, NOT_SET_UP, advice=_join("gpio"))
    return Finding.of("gpio", Message("The pins can be used."))


def _usable(path: Path) -> bool:
    return os.access(str(path), os.R_OK | os.W_OK)


def _join(group: str) -> Message:
    values = {"group": group, "user": getpass.getuser()}
    return Message("Run: sudo usermod -aG {group} {user}. Then log out and in.", **values)


def check_power(machine: Machine) -> Iterator[Finding]:
    """Judge the supply of a Raspberry Pi, as its firmware says."""
    if not machine.is_pi:
        return
    bits = int(answer_of(("vcgencmd", "get_throttled")).split("=")[-1], 16)
    text, fault = Message("Supply voltage of the Raspberry Pi"), faults.VOLTAGE_LOW
    if bits & LOW_NOW:
        text = Message("The supply voltage of the Raspberry Pi is too low now.")
    elif bits & (SLOW_NOW | LOW_BEFORE):
        text = Message(
            "The supply voltage of the Raspberry Pi was too low since its start, or it was "
            "slowed down."
        )
        fault = fault.as_warning()
    yield Finding.of("power", text, fault if bits & (LOW_NOW | SLOW_NOW | LOW_BEFORE) else None)


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
        file = machine.root / "usr/share/zoneinfo" / zone
        known = file.is_file() or bool(_RULE.fullmatch(zone))
        advice = Message("Run: unset TZ. If it is found again, remove TZ where it is set.")
    else:
        # Without the file the zone is UTC; a link that leads nowhere is a mistake.
        known = file.exists() or not os.path.islink(str(file))
        zone = "" if known else os.readlink(str(file))
        advice = Message("Run: sudo timedatectl set-timezone Europe/Madrid, or another zone.")
    if not known:
        text = Message("There is no time zone {zone}: local times are wrong.", zone=zone)
        yield Finding.of("zone", text, CLOCK_WRONG, mild=True, advice=advice)


def check_memory(machine: Machine) -> Iterator[Finding]:
    """Judge the memory that programs may still have."""
    free = _sizes(machine.root / "proc/meminfo")["MemAvailable"] * BYTES_PER_KB
    ended = _sizes(machine.root / "proc/vmstat").get("oom_kill", 0)
    text = Message("Memory: {free_mb:.0f} MB free", free_mb=free / MB)
    advice = Message(
        "End other programs on this computer; to see them, run: ps aux --sort=-rss | head"
    )
    if free >= LOW_MEMORY and ended:
        text = Message(
            "Linux has ended {count} programs for lack of memory since the start.", count=ended
        )
        advice = Message(
            "Note which program was ended: sudo dmesg | grep -i oom. Then restart the computer, "
            "and run nothing else beside the robot."
        )
    fault = OVERLOADED if free < LOW_MEMORY or ended else None
    yield Finding.of("memory", text, fault, mild=free >= NO_MEMORY, advice=advice)


def _sizes(path: Path) -> Dict[str, int]:
    rows = (line.replace(":", " ").split() for line in path.read_text().splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) > 1}
