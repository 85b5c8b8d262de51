"""What the back-projection needs to know about traces and delays.

The delays between antennas in air and points in the soil are in a table.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator, Tuple

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.a_scans import Transform
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_common.message import Message
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S, Number
from gpr20_survey.radar.refraction import one_way_delay_s, tangent_in_air

# The error of linear interpolation over the distance is less than step^2 / 8 times the second
# derivative of the delay: 0.5 mrad at 6 GHz and 0.1 m of height.
DISTANCE_STEP_M = 0.002
# A trace uses the nearest height with a vertical correction; its error is at most half a step times
# (1 - cos) of the angle: 0.13 mm at 60 deg.
HEIGHT_STEP_M = 0.0005
MOST_HEIGHTS = 200
# Traces that are transformed at once: about 20 MiB.
BLOCK = 2048


def surface_delay_s_per_m(
    height_m: Number, depth_m: Number, distance_m: Number, permittivity: float
) -> np.ndarray:
    """Return the delay added per metre that the surface is lower below the antenna [s/m].

    Lower than at the point, that is; between the two it is assumed to be a plane. By Fermat's
    principle the change of the path does not change the delay to the first order. What counts is
    how much lower the surface is where the path crosses it: that much more of the path is in air
    instead of soil.

    Args:
        height_m: Height of the antenna above the surface at the point [m], more than 0.
        depth_m: Depth of the point below the surface there [m], 0 or more.
        distance_m: Horizontal distance of the point [m], 0 or more.
        permittivity: Relative permittivity of the soil, 1 or more.
    """
    height_m, depth_m, distance_m = np.broadcast_arrays(height_m, depth_m, distance_m)
    tangent = tangent_in_air(height_m, depth_m, distance_m, permittivity)
    root = np.sqrt(permittivity + (permittivity - 1.0) * tangent**2)
    # Share of the horizontal distance beyond the crossing.
    beyond = (depth_m / root) / (height_m + depth_m / root)
    secant = np.sqrt(1.0 + tangent**2)
    # The wave number along the vertical is cos(angle) in air, sqrt(permittivity - sin^2) in soil.
    in_soil = np.sqrt(permittivity - (tangent / secant) ** 2)
    return beyond * (1.0 / secant - in_soil) / SPEED_OF_LIGHT_M_S


@dataclass(frozen=True)
class DelayTable:
    """One-way delays by height, distance and depth.

    Attributes:
        delay_s: Delays (height, distance, depth), float32 [s].
        lowest_m: First height [m].
        height_step_m: Step of the heights [m].
        distance_step_m: Step of the distances, which start at 0 [m].
        surface_s_per_m: Delay added per metre that the surface is lower below the antenna than at
            the point (distance, depth), at the mean height [s/m].
    """

    delay_s: np.ndarray
    lowest_m: float
    height_step_m: float
    distance_step_m: float
    surface_s_per_m: np.ndarray


def tabulate_delays(
    height_m: np.ndarray, depth_m: np.ndarray, furthest_m: float, permittivity: float
) -> DelayTable:
    """Tabulate the delays between antennas at some heights and points in the soil.

    Args:
        height_m: Heights of the antennas [m], any shape.
        depth_m: Depths of the points [m].
        furthest_m: Largest horizontal distance [m].
        permittivity: Relative permittivity of the soil.
    """
    lowest_m, range_m = float(np.min(height_m)), float(np.ptp(height_m))
    step_m = max(HEIGHT_STEP_M, range_m / MOST_HEIGHTS)
    heights = 1 + math.ceil(range_m / step_m)
    # Two beyond the furthest, so that its right neighbour exists.
    distances = 3 + math.ceil(furthest_m / DISTANCE_STEP_M)
    distance_m = (DISTANCE_STEP_M * np.arange(distances))[:, None]
    # Height by height, because the iterations need several times the memory of their result.
    delay_s = np.empty((heights, distances, len(depth_m)), dtype=np.float32)
    for one, own in enumerate(delay_s):
        own[:] = one_way_delay_s(
            lowest_m + step_m * one, depth_m[None, :], distance_m, permittivity
        )
    surface_s_per_m = surface_delay_s_per_m(
        float(np.mean(height_m)), depth_m[None, :], distance_m, permittivity
    )
    return DelayTable(delay_s, lowest_m, step_m, DISTANCE_STEP_M, surface_s_per_m)


@dataclass(frozen=True)
class Scene:
    """Traces and delays, for either way.

    Attributes:
        traces: The traces.
        focus: How to focus.
        x_m: Positions of the image along X [m].
        y_m: The same along Y.
        held: Which traces are not zero (trace).
        height_m: Height of the antennas (trace) [m].
        side_m: From the middle of the antennas to the transmitter (x, y) [m].
        in_air: Horizontal reach of the widest ray per height.
        in_soil: The same per depth.
        table: One-way delays.
        transform: Makes the A-scans.
    """

    traces: Traces
    focus: Focus
    x_m: np.ndarray
    y_m: np.ndarray
    held: np.ndarray
    height_m: np.ndarray
    side_m: np.ndarray
    in_air: float
    in_soil: float
    table: DelayTable
    transform: Transform

    def a_scans(self, held: np.ndarray) -> Iterator[Tuple[slice, np.ndarray]]:
        """Yield the A-scans of some traces in blocks (trace, delay), each with its place.

        Args:
            held: Indices of the traces.
        """
        spectra = self.traces.s21.reshape(-1, self.traces.sweep.count)
        for first in range(0, len(held), BLOCK):
            block = slice(first, first + BLOCK)
            yield block, self.transform.a_scans(spectra[held[block]])

    @property
    def delays(self) -> np.ndarray:
        """One-way delays in samples (height, distance, depth), float32."""
        return self.table.delay_s / np.float32(self.transform.sample_s)

    def levels(self, height_m: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Return the index of the nearest height in the table, and the remaining delay."""
        step_m = self.table.height_step_m
        level = np.rint((height_m - self.table.lowest_m) / step_m).astype(np.int32)
        more_m = height_m - self.table.lowest_m - step_m * level
        more = more_m / SPEED_OF_LIGHT_M_S / self.transform.sample_s
        return level, more.astype(np.float32)


def scene_of(traces: Traces, focus: Focus, x_m: np.ndarray, y_m: np.ndarray) -> Scene:
    """Return what the back-projection of traces to positions x_m, y_m needs.

    Raises:
        WrongDatasetError: All traces are zero.
    """
    held = np.any(traces.s21, axis=2).ravel()
    if not np.any(held):
        raise WrongDatasetError(
            Message(
                "every trace is zero or was left out, so there is nothing to image; see gpr20 info"
            ),
            fault=faults.INPUT,
        )
    # Also where a trace is zero: uneven ground is interpolated between all heights.
    height_m = np.asarray(traces.height_m, dtype=np.float64).ravel()
    apart_m, turn = focus.separation_m / 2.0, np.radians(traces.rotation_deg)
    sine = np.sin(np.radians(focus.widest_angle_deg))
    in_air = float(sine / np.sqrt(max(1.0 - sine**2, 1e-6)))
    in_soil = float(sine / np.sqrt(max(focus.permittivity - sine**2, 1e-6)))
    spread_m = [
        max(np.max(axis_m) - np.min(place_m), np.max(place_m) - np.min(axis_m))
        for axis_m, place_m in ((x_m, traces.x_m), (y_m, traces.y_m))
    ]
    reach_m = float(height_m.max()) * in_air + float(focus.depth_m[-1]) * in_soil
    furthest_m = min(float(np.hypot(*spread_m)), reach_m)
    table = tabulate_delays(height_m, focus.depth_m, furthest_m + apart_m, focus.permittivity)
    lower_s = float(np.ptp(height_m) * np.abs(table.surface_s_per_m).max())
    longest_s = 2.0 * (float(table.delay_s.max()) + lower_s)
    return Scene(
        *(traces, focus, x_m, y_m, held, height_m),
        side_m=apart_m * np.array([np.cos(turn), np.sin(turn)]),
        in_air=in_air,
        in_soil=in_soil,
        table=table,
        transform=Transform.until(longest_s, traces.sweep, focus.window),
    )
