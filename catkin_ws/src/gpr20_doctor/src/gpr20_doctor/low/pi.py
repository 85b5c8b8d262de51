"""What Linux and the firmware show of a Raspberry Pi: sensors, devices, groups and limits."""

from __future__ import annotations

import importlib.util
import os
import pwd
import resource
import threading
from pathlib import Path
from typing import Dict, FrozenSet, List, Mapping, Optional, Sequence, Tuple

MODEL = "proc/device-tree/model"
TEMPERATURES = "sys/class/thermal/thermal_zone*/temp"
SUPPLIES = "sys/class/hwmon/hwmon*/name"
SUPPLY_NAME = "rpi_volt"
ALARM = "in0_lcrit_alarm"
MILLIDEGREES = 1000.0
GPIO_FILES = ("dev/gpiomem", "dev/gpiochip*")
# Where the daemon of the library pigpio listens.
DAEMON_PORT = 8888
GROUP_FILE = "etc/group"


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


def low_voltage(root: Path) -> Optional[bool]:
    """Return whether the supply of a Raspberry Pi is too low now; None if that is not shown.

    Raises:
        OSError: It cannot be read.
        ValueError: It is no number.
    """
    for name in sorted(root.glob(SUPPLIES)):
        if name.read_text().strip() == SUPPLY_NAME:
            return bool(int(name.with_name(ALARM).read_text()))
    return None


def spi_device(root: Path, bus: int, device: int) -> Path:
    """Return the file of a device on an SPI bus."""
    return root / f"dev/spidev{bus}.{device}"


def gpio_devices(root: Path) -> Tuple[Path, ...]:
    """Return the files through which libraries reach the pins."""
    return tuple(path for pattern in GPIO_FILES for path in sorted(root.glob(pattern)))


def can_be_used(path: Path) -> bool:
    """Return whether a device may be read and written; False if it is missing."""
    return os.access(str(path), os.R_OK | os.W_OK)


def installed(modules: Mapping[str, str]) -> FrozenSet[str]:
    """Return which libraries this interpreter finds, without loading them.

    Args:
        modules: The module of each library.
    """
    return frozenset(name for name, module in modules.items() if _is_found(module))


def _is_found(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ImportError:
        return False


def user_name() -> str:
    """Return the name of the user of this process; its number if it has no name."""
    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return str(os.geteuid())


def group_names(root: Path) -> Dict[int, str]:
    """Return the groups of a computer by their numbers.

    Raises:
        OSError: They cannot be read.
    """
    return {number: name for name, number, _users in _groups(root)}


def groups_listing(root: Path, user: str) -> FrozenSet[str]:
    """Return the groups that list a user.

    Raises:
        OSError: They cannot be read.
    """
    return frozenset(name for name, _number, users in _groups(root) if user in users)


def _groups(root: Path) -> Sequence[Tuple[str, int, Sequence[str]]]:
    text = (root / GROUP_FILE).read_text(encoding="utf-8", errors="replace")
    rows = [line.split(":") for line in text.splitlines()]
    whole = [row for row in rows if len(row) == 4 and row[2].isdigit()]
    return [(row[0], int(row[2]), row[3].split(",")) for row in whole]


def priority_limit() -> int:
    """Return the highest real-time priority that this user may set."""
    return resource.getrlimit(resource.RLIMIT_RTPRIO)[0]


def memory_limit() -> Optional[int]:
    """Return how much memory this user may lock [bytes]; None: no limit."""
    limit = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    return None if limit == resource.RLIM_INFINITY or os.geteuid() == 0 else limit


def can_set_priority(priority: int) -> bool:
    """Return whether SCHED_FIFO with a priority is granted."""
    granted: List[bool] = []

    def try_it() -> None:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except OSError:
            granted.append(False)
        else:
            granted.append(True)

    # In Linux it holds for the calling thread, and this one ends at once.
    thread = threading.Thread(target=try_it)
    thread.start()
    thread.join()
    return granted == [True]
