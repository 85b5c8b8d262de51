"""A mounted removable volume, as fields of gpr20_msgs/Volume, and back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict


@dataclass(frozen=True)
class Volume:
    """A mounted USB stick, or another removable volume.

    Attributes:
        path: Where it is mounted, on the computer of the storage.
        name: Its label, or that of its device.
        free_bytes: What can be written [bytes].
        writable: Whether the node may write to it.
        device: Number of the device; another stick at the same place has another one. 0: not known,
            as on other computers.
    """

    path: str
    name: str
    free_bytes: int
    writable: bool
    device: int = 0


FIELDS = ("path", "name", "free_bytes", "writable")


def volume_fields(volume: Volume) -> Dict[str, Any]:
    """Return the fields of a volume."""
    return {name: getattr(volume, name) for name in FIELDS}


def volume_from(message: Any) -> Volume:
    """Return the volume of a message."""
    return Volume(**{name: getattr(message, name) for name in FIELDS})
