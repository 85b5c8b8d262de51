"""What the back-projection needs to know about traces and delays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Tuple

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.a_scans import Transform
from gpr20_analysis.imaging.projection.delay_table import DelayTable, tabulate_delays
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_common.message import Message
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S

# Traces that are transformed at once: about 20 MiB.
BLOCK = 2048


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
