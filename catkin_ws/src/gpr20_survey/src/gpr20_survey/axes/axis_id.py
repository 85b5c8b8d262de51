"""The names of the axes."""

from __future__ import annotations

import enum


class AxisId(enum.Enum):
    """The three axes, with the unit of their coordinates."""

    X = "x"
    Y = "y"
    Z = "z"

    @property
    def unit(self) -> str:
        """Unit of the coordinates: mm or deg."""
        return "deg" if self is AxisId.Z else "mm"
