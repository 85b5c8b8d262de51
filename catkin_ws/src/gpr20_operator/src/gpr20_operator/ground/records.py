"""The operator's settings, and pictures of the ground that are ready to be painted."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Tuple

import numpy as np

from gpr20_operator.ground.level_scale import LevelScale


class Axis(enum.Enum):
    """What the axis of a picture is."""

    DELAY_NS = "delay"
    DEPTH_MM = "depth"
    X_MM = "x"
    Y_MM = "y"


class Colours(enum.Enum):
    """How shades become colours."""

    ENVELOPE = "envelope"
    """The magnitude of the wave."""
    GREY = "grey"
    """The wave with its sign, black to white."""
    RED_WHITE_BLUE = "red white blue"
    """The wave with its sign."""

    @property
    def signed(self) -> bool:
        """Whether the sign of the wave is shown."""
        return self is not Colours.ENVELOPE


@dataclass(frozen=True)
class Place:
    """A place above the ground [mm]."""

    x_mm: float
    y_mm: float

    def along(self, axis: Axis) -> float:
        return self.x_mm if axis is Axis.X_MM else self.y_mm


@dataclass(frozen=True)
class RadarSettings:
    """What the operator chose.

    Args:
        polarization: Number of the antenna rotation, from 0.
        in_depth: Depth by permittivity instead of delay.
        in_db: Shades follow the level in dB instead of the amplitude.
        remove_background: Take out what all traces of this polarization have in common.
        permittivity: Relative permittivity of the ground.
        gain_db_per_ns: By how much later echoes are shown stronger [dB/ns].
        depth_m: Depth of the slice and of the crosshair [m].
        along: Axis that the line is parallel to: X or Y.
        colours: How shades become colours.
    """

    polarization: int = 0
    in_depth: bool = True
    in_db: bool = True
    remove_background: bool = True
    permittivity: float = 4.0
    gain_db_per_ns: float = 0.0
    depth_m: float = 0.05
    along: Axis = Axis.X_MM
    colours: Colours = Colours.ENVELOPE


@dataclass(frozen=True)
class Curve:
    """An A-scan.

    Args:
        places: Delay [ns] or depth [mm].
        shades: Place of each level in the scale, -1 to 1 if signed, else 0 to 1.
        axis: What the places are.
        scale: The scale of the survey.
        signed: Whether the sign of the wave is shown.
    """

    places: np.ndarray
    shades: np.ndarray
    axis: Axis
    scale: LevelScale
    signed: bool = False


@dataclass(frozen=True)
class Picture:
    """A line (B-scan) or a slice (C-scan).

    Args:
        shades: Place of each level in the scale, shape (second axis, across), -1 to 1 if signed,
            else 0 to 1; NaN where nothing was measured.
        across_mm: Outer edges along the first axis [mm].
        range: Outer edges along the second axis.
        axis: What the second axis is.
        scale: The scale of the survey.
        above_noise: Whether any level is above all noise.
        signed: Whether the sign of the wave is shown.
    """

    shades: np.ndarray
    across_mm: Tuple[float, float]
    range: Tuple[float, float]
    axis: Axis
    scale: LevelScale
    above_noise: bool
    signed: bool = False

    @property
    def measured(self) -> bool:
        """Whether there is anything to see."""
        return bool(np.isfinite(self.shades).any())


def ascending(places_mm: np.ndarray) -> Tuple[slice, Tuple[float, float]]:
    """Return the order in which places ascend, and the outer edges of their cells."""
    order = slice(None) if places_mm[0] <= places_mm[-1] else slice(None, None, -1)
    return order, edges(places_mm[order])


def edges(places: np.ndarray) -> Tuple[float, float]:
    """Return the outer edges of cells around evenly spaced places."""
    half = abs(places[1] - places[0]) / 2.0 if len(places) > 1 else 0.5
    return float(places[0] - half), float(places[-1] + half)
