"""Files of devices."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Tuple

GPIO_FILES = ("dev/gpiomem", "dev/gpiochip*")


def spi_device(root: Path, bus: int, device: int) -> Path:
    """Return the file of a device on an SPI bus."""
    return root / f"dev/spidev{bus}.{device}"


def can_be_used(path: Path) -> bool:
    """Return whether a device may be read and written; False if it is missing."""
    return os.access(str(path), os.R_OK | os.W_OK)


def gpio_devices(root: Path) -> Tuple[Path, ...]:
    """Return the files through which libraries reach the pins."""
    return tuple(path for pattern in GPIO_FILES for path in sorted(root.glob(pattern)))
