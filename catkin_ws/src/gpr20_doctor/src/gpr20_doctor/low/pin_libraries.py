"""The libraries for the pins of a Raspberry Pi."""

from __future__ import annotations

import importlib.util
from typing import FrozenSet

# By the names of the configuration.
LIBRARIES = {"rpi_gpio": "RPi.GPIO", "pigpio": "pigpio"}
DAEMON_PORT = 8888


def installed() -> FrozenSet[str]:
    """Return which libraries this interpreter finds, without loading them."""
    return frozenset(name for name, module in LIBRARIES.items() if _is_found(module))


def _is_found(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ImportError:
        return False
