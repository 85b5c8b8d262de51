"""Where the antennas are."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AntennaPosition:
    """Place and rotation of the antenna pair over the ground.

    Attributes:
        x_mm: Position of the carriage along X [mm].
        y_mm: Position of the carriage along Y [mm].
        rotation_deg: Rotation of the antennas about the vertical [deg].
    """

    x_mm: float
    y_mm: float
    rotation_deg: float
