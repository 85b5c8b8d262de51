"""Temperature and supply of a computer, as Linux and the firmware of a Raspberry Pi show them."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Optional

MODEL = "proc/device-tree/model"
TEMPERATURES = "sys/class/thermal/thermal_zone*/temp"
SUPPLIES = "sys/class/hwmon/hwmon*/name"
SUPPLY_NAME = "rpi_volt"
ALARM = "in0_lcrit_alarm"
FIRMWARE = "vcgencmd"
LIMIT_S = 1.0
MILLIDEGREES = 1000.0


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


def throttled_bits(program: str = FIRMWARE) -> Optional[int]:
    """Return what the firmware says of voltage and speed; None without its program.

    Raises:
        OSError: The program failed, or did not end in time.
        ValueError: Its answer is no number.
    """
    path = shutil.which(program)
    if path is None:
        return None
    try:
        answer = subprocess.run(
            [path, "get_throttled"], capture_output=True, timeout=LIMIT_S, check=True
        )
    except subprocess.SubprocessError as error:
        raise OSError(str(error)) from error
    return int(answer.stdout.decode(errors="replace").split("=")[-1], 16)
