"""What a node drives, as the node itself knows it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Hardware:
    """What a node drives.

    Attributes:
        name: What diagnostics and recordings call it; empty for a node without hardware.
        simulated: Whether it is simulated.
        time_scale: How many times faster than the real hardware it runs; 1 for the real one.
    """

    name: str
    simulated: bool = False
    time_scale: float = 1.0


NO_HARDWARE = Hardware("")
