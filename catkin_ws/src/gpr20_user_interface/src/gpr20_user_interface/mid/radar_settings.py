"""How radar data are shown; nothing here changes them."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

MIN_PERMITTIVITY, MAX_PERMITTIVITY = 1.0, 81.0  # air, water
MAX_GAIN_DB_PER_NS = 10.0


class Axis(enum.Enum):
    """What the second axis of a picture is."""

    DELAY_NS = "delay"
    DEPTH_MM = "depth"
    Y_MM = "y"


@dataclass(frozen=True)
class RadarSettings:
    """What the operator chose.

    Args:
        polarization: Number of the antenna rotation, from 0.
        in_depth: Depth by permittivity instead of delay.
        in_db: Decibels instead of a linear scale.
        remove_background: Take out what all traces of this polarization have in common.
        permittivity: Relative permittivity of the ground.
        gain_db_per_ns: By how much later echoes are shown stronger [dB/ns].
        depth_m: Depth of the slice [m].
    """

    polarization: int = 0
    in_depth: bool = True
    in_db: bool = True
    remove_background: bool = False
    permittivity: float = 4.0
    gain_db_per_ns: float = 0.0
    depth_m: float = 0.05


@dataclass(frozen=True)
class Curve:
    """An A-scan.

    Args:
        places: Delay [ns] or depth [mm].
        levels: Amplitude, linear or in dB.
        axis: What the places are.
    """

    places: np.ndarray
    levels: np.ndarray
    axis: Axis


@dataclass(frozen=True)
class Picture:
    """A B- or C-scan.

    Args:
        levels: Amplitude, linear or in dB, shape (second axis, x); NaN where nothing was measured.
        x_range_mm: Outer edges along X.
        range: Outer edges along the second axis.
        axis: What the second axis is.
    """

    levels: np.ndarray
    x_range_mm: tuple
    range: tuple
    axis: Axis

    @property
    def measured(self) -> bool:
        """Whether there is anything to see."""
        return bool(np.isfinite(self.levels).any())
