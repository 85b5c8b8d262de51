"""A mounted removable volume."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Volume:
    """A mounted USB stick, or another removable volume; but for the device it is sent as it is.

    Attributes:
        device: Its number; another stick at the same place has another one. 0: not known, as on
            other computers.
    """

    path: str
    name: str
    free_bytes: int
    writable: bool
    device: int = 0
