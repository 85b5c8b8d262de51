"""What Linux and the firmware show of a Raspberry Pi: sensors, devices, groups and limits."""

from __future__ import annotations

import importlib.util
import os
import pwd
import resource
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import FrozenSet, List, Optional, Tuple

from gpr20_doctor.low.programs import ANSWER_LIMIT_S, answer_of

MODEL = "proc/device-tree/model"
TEMPERATURES = "sys/class/thermal/thermal_zone*/temp"
MILLIDEGREES = 1000.0
FIRMWARE = ("vcgencmd", "get_throttled")
# Bits of its answer: low voltage now and before, slowed down now.
LOW_NOW, SLOW_NOW, LOW_BEFORE = 1 << 0, 1 << 2, 1 << 16
SUPPLIES, SUPPLY_NAME, ALARM = "sys/class/hwmon/hwmon*/name", "rpi_volt", "in0_lcrit_alarm"
GPIO_FILES = ("dev/gpiomem", "dev/gpiochip*")
# The library of the pins.
PIN_MODULE = "RPi.GPIO"
GROUP_FILE = "etc/group"


@dataclass(frozen=True)
class Power:
    """Supply of a Raspberry Pi.

    Attributes:
        low_now: Whether its voltage is too low now.
        low_before: Whether it was so since the computer started, or it is slowed down.
    """

    low_now: bool
    low_before: bool = False


@dataclass(frozen=True)
class DeviceFile:
    """A device of this computer.

    Attributes:
        path: Its file.
        exists: Whether it is there.
        usable: Whether it can be read and written.
    """

    path: Path
    exists: bool
    usable: bool


@dataclass(frozen=True)
class Pins:
    """Access to the pins.

    Attributes:
        devices: Files through which libraries reach the pins.
        library: Whether the library of the pins is installed.
    """

    devices: Tuple[DeviceFile, ...]
    library: bool


@dataclass(frozen=True)
class Groups:
    """Groups of the user of this process.

    Attributes:
        user: Name of the user; the number if there is no name.
        is_root: Whether the user may do everything.
        existing: Names of the groups of this computer.
        member: Groups that this process has.
        listed: Groups that the user has at the next login.
    """

    user: str
    is_root: bool
    existing: FrozenSet[str]
    member: FrozenSet[str]
    listed: FrozenSet[str]


@dataclass(frozen=True)
class Realtime:
    """Limits of a process that makes pulses.

    Attributes:
        priority: Highest real-time priority that the user may set.
        granted: Whether the priority of the pulses could be set.
        locked_bytes: Memory that the user may lock [bytes]; None: no limit.
    """

    priority: int
    granted: bool
    locked_bytes: Optional[int]


def is_raspberry_pi(root: Path) -> bool:
    """Return whether a computer is a Raspberry Pi."""
    try:
        return b"Raspberry Pi" in (root / MODEL).read_bytes()
    except OSError:
        return False


def hottest_c(root: Path) -> Optional[float]:
    """Return the temperature of the hottest zone [°C]; None if there is none.

    Raises:
        OSError: A zone cannot be read.
        ValueError: It is no number.
    """
    zones = sorted(root.glob(TEMPERATURES))
    return max((float(one.read_text()) / MILLIDEGREES for one in zones), default=None)


def power(root: Path) -> Power:
    """Return what the firmware says of the supply, or without its program the sensor of Linux.

    Raises:
        OSError: It cannot be read, or did not answer in time.
        ValueError: It is not shown, or not understood.
    """
    try:
        bits = int(answer_of(FIRMWARE, ANSWER_LIMIT_S).split("=")[-1], 16)
        return Power(bool(bits & LOW_NOW), bool(bits & (LOW_BEFORE | SLOW_NOW)))
    except FileNotFoundError:
        names = [
            one for one in sorted(root.glob(SUPPLIES)) if one.read_text().strip() == SUPPLY_NAME
        ]
    if not names:
        raise ValueError("neither vcgencmd nor rpi_volt")
    return Power(bool(int(names[0].with_name(ALARM).read_text())))


def spi_device(root: Path, bus: int, device: int) -> DeviceFile:
    """Return a device on an SPI bus."""
    return _device(root / f"dev/spidev{bus}.{device}")


def pins(root: Path) -> Pins:
    """Return what gives access to the pins."""
    paths = [path for pattern in GPIO_FILES for path in sorted(root.glob(pattern))]
    return Pins(tuple(map(_device, paths)), is_installed(PIN_MODULE))


def _device(path: Path) -> DeviceFile:
    return DeviceFile(path, path.exists(), os.access(str(path), os.R_OK | os.W_OK))


def is_installed(module: str) -> bool:
    """Return whether this interpreter finds a module, without loading it."""
    try:
        return importlib.util.find_spec(module) is not None
    except ImportError:
        return False


def groups(root: Path) -> Groups:
    """Return the groups of a computer, and those of the user of this process.

    Raises:
        OSError: They cannot be read.
    """
    text = (root / GROUP_FILE).read_text(encoding="utf-8", errors="replace")
    rows = [line.split(":") for line in text.splitlines()]
    known = {int(row[2]): row for row in rows if len(row) == 4 and row[2].isdigit()}
    try:
        user = pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        user = str(os.geteuid())
    own = {*os.getgroups(), os.getegid()} & set(known)
    return Groups(
        user,
        os.geteuid() == 0,
        existing=frozenset(row[0] for row in known.values()),
        member=frozenset(known[number][0] for number in own),
        listed=frozenset(row[0] for row in known.values() if user in row[3].split(",")),
    )


def realtime(priority: int) -> Realtime:
    """Return what the system grants to a process with a real-time priority."""
    locked = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    unlimited = locked == resource.RLIM_INFINITY or os.geteuid() == 0
    highest = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    return Realtime(highest, _can_set(priority), None if unlimited else locked)


def _can_set(priority: int) -> bool:
    granted: List[bool] = []

    def try_it() -> None:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except OSError:
            return
        granted.append(True)

    # In Linux it holds for the calling thread, and this one ends at once.
    thread = threading.Thread(target=try_it)
    thread.start()
    thread.join()
    return bool(granted)
