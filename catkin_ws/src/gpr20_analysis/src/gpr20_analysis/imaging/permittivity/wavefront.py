"""When the echo of a buried body arrives at each position of the antennas.

A body reflects from that of its points where the angles of both rays to its surface are equal. For
a sphere the path is that to its centre, shorter by its radius on both rays. With radius 0 it is a
point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np

from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S, Number
from gpr20_survey.radar.refraction import tangent_in_air


@dataclass(frozen=True)
class Stops:
    """Positions of the antennas.

    Attributes:
        x_m: Middle of the two antennas along X [m].
        y_m: The same along Y [m].
        height_m: Height above the surface [m].
        offset_m: From the middle to one antenna, as a vector (x, y) [m].
    """

    x_m: np.ndarray
    y_m: np.ndarray
    height_m: np.ndarray
    offset_m: Tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Wavefront:
    """Two-way delays of one echo and their derivatives.

    Attributes:
        delay_s: Delay at each position [s].
        slopes: Change with x, y and optical depth (3, ...) [s/m].
        cosine: Mean cosine of the angles to the vertical in air.
    """

    delay_s: np.ndarray
    slopes: np.ndarray
    cosine: np.ndarray


def wavefront(
    stops: Stops,
    place_m: Tuple[float, float],
    optical_m: Number,
    permittivity: Number,
    radius_m: Number,
) -> Wavefront:
    """Return the echo of a sphere.

    Args:
        stops: Positions of the antennas.
        place_m: Centre (x, y) of the sphere [m].
        optical_m: Depth of its top times the refractive index [m].
        permittivity: Relative permittivity of the soil.
        radius_m: Its radius [m]; 0 for a point.
    """
    index = np.sqrt(permittivity)
    centre_m = optical_m / index + radius_m
    optical = 0.0
    rays, cosines = [], []
    sides = (1.0, -1.0) if any(stops.offset_m) else (1.0,)
    for side in sides:
        x_m = place_m[0] - stops.x_m - side * stops.offset_m[0]
        y_m = place_m[1] - stops.y_m - side * stops.offset_m[1]
        distance_m = np.hypot(x_m, y_m)
        tangent = tangent_in_air(stops.height_m, centre_m, distance_m, permittivity)
        cosine = 1.0 / np.sqrt(1.0 + tangent**2)
        sine = tangent * cosine
        cosine_in_soil = np.sqrt(1.0 - (sine / index) ** 2)
        optical = optical + stops.height_m / cosine + index * centre_m / cosine_in_soil
        across = sine / np.maximum(distance_m, 1e-9)
        rays.append((across * x_m, across * y_m, cosine_in_soil))
        cosines.append(cosine)
    first, second = rays[0], rays[-1]
    twice = 2.0 / len(rays)
    between = sum(a * b for a, b in zip(first[:2], second[:2])) / permittivity
    half = np.sqrt((1.0 + between + first[2] * second[2]) / 2.0)
    delay_m = twice * optical - 2.0 * radius_m * index * half
    slopes_m = np.stack([first[0] + second[0], first[1] + second[1], first[2] + second[2]])
    return Wavefront(
        delay_m / SPEED_OF_LIGHT_M_S,
        slopes_m / SPEED_OF_LIGHT_M_S,
        (cosines[0] + cosines[-1]) / 2.0,
    )


def antenna_offset_m(traces: Traces, focus: Focus) -> Tuple[float, float]:
    """Return the vector (x, y) from the middle of the two antennas to one of them [m]."""
    half_m, rotation_rad = focus.separation_m / 2.0, np.radians(traces.rotation_deg)
    # A combination of polarizations has no rotation.
    if half_m == 0.0 or not np.isfinite(rotation_rad):
        return 0.0, 0.0
    return float(half_m * np.cos(rotation_rad)), float(half_m * np.sin(rotation_rad))
