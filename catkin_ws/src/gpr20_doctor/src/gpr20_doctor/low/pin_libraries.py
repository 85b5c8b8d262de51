"""The libraries for the pins of a Raspberry Pi."""

from __future__ import annotations

import importlib.util
from typing import FrozenSet, Mapping

DAEMON_PORT = 8888


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
