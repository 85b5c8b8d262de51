"""The inputs of the imaging methods."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np

from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_survey.radar.frequency_to_delay import Window


class Ground(enum.Enum):
    """Why the recorded heights differ."""

    LEVEL = "level"
    """The ground is level, the antennas move up and down."""
    UNEVEN = "uneven"
    """The antennas move in a level plane, the ground rises and falls."""


@dataclass(frozen=True)
class Traces:
    """The traces of one polarization, without NaN; a trace that is left out is zero.

    Attributes:
        s21: Complex spectra (y, x, frequency).
        sweep: Their frequencies.
        x_m: Positions along X [m].
        y_m: Positions along Y [m].
        height_m: Height of the antennas at each position (y, x) [m].
        rotation_deg: Rotation of the antennas [deg].
    """

    s21: np.ndarray
    sweep: FrequencyGrid
    x_m: np.ndarray
    y_m: np.ndarray
    height_m: np.ndarray
    rotation_deg: float


@dataclass(frozen=True)
class Focus:
    """How an image is focused.

    Attributes:
        permittivity: Relative permittivity of the soil, 1 or more.
        depth_m: Depths of the image [m], ascending, 0 or more.
        window: Weights over the band.
        widest_angle_deg: Waves that arrive in air at a wider angle to the vertical are left out.
        separation_m: Distance between the two antennas, along their rotation [m]; the phase
            shift ignores it.
        ground: Why the recorded heights differ; only the back-projection supports uneven ground,
            where depths are relative to the local surface.
    """

    permittivity: float
    depth_m: np.ndarray
    window: Window = Window.HANN
    widest_angle_deg: float = 70.0
    separation_m: float = 0.0
    ground: Ground = Ground.LEVEL


def antenna_offset_m(traces: Traces, focus: Focus) -> Tuple[float, float]:
    """Return the vector (x, y) from the middle of the two antennas to one of them [m]."""
    half_m, rotation_rad = focus.separation_m / 2.0, np.radians(traces.rotation_deg)
    # A combination of polarizations has no rotation.
    if half_m == 0.0 or not np.isfinite(rotation_rad):
        return 0.0, 0.0
    return float(half_m * np.cos(rotation_rad)), float(half_m * np.sin(rotation_rad))


def reach(focus: Focus) -> Tuple[float, float]:
    """Return the horizontal reach of the widest ray per height and per depth."""
    sine = math.sin(math.radians(focus.widest_angle_deg))
    in_air = sine / math.sqrt(max(1.0 - sine**2, 1e-6))
    return in_air, sine / math.sqrt(max(focus.permittivity - sine**2, 1e-6))


def longer_m(deep_m: float, separation_m: float) -> float:
    """Return how much longer the way between antennas that are apart is than that down [m]."""
    return float(np.hypot(deep_m, separation_m / 2.0)) - deep_m
