"""What a node drives, as the node itself knows it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Hardware:
    """What diagnostics and recordings call it, and how many times faster than real it runs."""

    name: str
    simulated: bool = False
    time_scale: float = 1.0


NO_HARDWARE = Hardware("")
