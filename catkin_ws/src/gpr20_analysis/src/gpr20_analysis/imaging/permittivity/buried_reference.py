"""The permittivity from the echo of an object that was buried at a known depth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np

from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.permittivity.aligned_sums import levels_at
from gpr20_analysis.imaging.permittivity.known_permittivity import KnownPermittivity, Source
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.processing.surface_reflection import WIDEST_RATIO
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.depth import one_way_path_m
from gpr20_survey.radar.soils import MAX_PERMITTIVITY

# How far the object may be from the place that was given.
AWAY_M = np.linspace(-0.03, 0.03, 5)
OPTICAL_STEP_M = 0.003
# Of depth and height as people and sensors measure them; twice that is the 95 % range.
DEPTH_DEVIATION_M, HEIGHT_DEVIATION_M = 0.003, 0.003
# Of the resolution in air: how well the delay of an echo is known.
OF_RESOLUTION = 0.2
# Of the median over all depths, and of the strongest echo.
CLEAR, STRONG = 4.0, 0.5
# Of the median of the strongest echoes at places beside it.
STANDS_OUT, BESIDE_M, BESIDE_STEP_M, FEWEST_BESIDE = 3.0, 0.12, 0.06, 3


@dataclass(frozen=True)
class BuriedReference:
    """An object of metal that was buried on purpose.

    Attributes:
        x_m: Its middle along X [m].
        y_m: Its middle along Y [m].
        depth_m: Depth of its top below the surface [m].
    """

    x_m: float
    y_m: float
    depth_m: float


def permittivity_of_reference(
    traces: Sequence[Traces], focus: Focus, reference: BuriedReference
) -> KnownPermittivity:
    """Return the permittivity that puts the echo of the reference at its depth.

    Args:
        traces: One item per polarization, without coupling and surface echo.
        focus: Window and antenna separation; its depths and permittivity are not used.
        reference: The object.

    Raises:
        WrongDatasetError: No trace is near it, or no clear echo of it.
    """
    if not all(_is_over(one, reference) for one in traces):
        raise _refused(Message("it is outside of the survey"), reference)
    level, optical_m = max(_echo(one, focus, reference) for one in traces)
    if not level >= CLEAR:
        raise _refused(Message("not one clear echo is below that place"), reference)
    band_hz = traces[0].sweep.step_hz * traces[0].sweep.count
    resolution_m = float(one_way_path_m(1.0 / band_hz))
    of_echo = float(np.hypot(OF_RESOLUTION * resolution_m, HEIGHT_DEVIATION_M)) / optical_m
    # The surface above it may be as much higher or lower as the heights differ.
    relief_m = max(float(np.std(one.height_m)) for one in traces)
    of_depth = float(np.hypot(DEPTH_DEVIATION_M, relief_m)) / reference.depth_m
    # Of the square of a quotient: twice its share; the range is two deviations.
    spread = 4.0 * float(np.hypot(of_echo, of_depth))
    permittivity = (optical_m / reference.depth_m) ** 2
    lowest, highest = max(permittivity / math.exp(spread), 1.0), permittivity * math.exp(spread)
    if not (permittivity > 1.0 and highest <= WIDEST_RATIO * lowest):
        raise _refused(Message("it is too shallow for the band and the heights"), reference)
    return KnownPermittivity(permittivity, lowest, highest, Source.BURIED)


def _is_over(traces: Traces, reference: BuriedReference) -> bool:
    at_m, reach_m = (reference.x_m, reference.y_m), float(AWAY_M[-1])
    axes_m = (traces.x_m, traces.y_m)
    return all(a.min() - reach_m <= at <= a.max() + reach_m for a, at in zip(axes_m, at_m))


def _beside(traces: Traces, reference: BuriedReference) -> List[Tuple[float, float]]:
    """Return places of the survey that are away from the reference."""
    x_m, y_m = (
        np.arange(axis_m.min(), axis_m.max() + 1e-9, BESIDE_STEP_M)
        for axis_m in (traces.x_m, traces.y_m)
    )
    return [
        (float(x), float(y))
        for x in x_m
        for y in y_m
        if np.hypot(x - reference.x_m, y - reference.y_m) > BESIDE_M
    ]


def _echo(traces: Traces, focus: Focus, reference: BuriedReference) -> Tuple[float, float]:
    """Return how far the strongest echo is above the others, and its depth times the index [m]."""
    deepest_m = reference.depth_m * np.sqrt(MAX_PERMITTIVITY)
    unambiguous_m = one_way_path_m(traces.sweep.unambiguous_s) - float(traces.height_m.max())
    optical_m = np.arange(
        0.8 * reference.depth_m, min(deepest_m, unambiguous_m / 2.0), OPTICAL_STEP_M
    )
    places = [
        (reference.x_m + x_m, reference.y_m + y_m)
        for x_m in (AWAY_M if len(traces.x_m) > 1 else [0.0])
        for y_m in (AWAY_M if len(traces.y_m) > 1 else [0.0])
    ]
    level = levels_at(traces, focus, places, optical_m).max(axis=0)
    # Residue of the surface or another body may be as strong: then they cannot be distinguished.
    inner = level[1:-1]
    tops = (inner > level[:-2]) & (inner >= level[2:]) & (inner >= STRONG * level.max())
    beside = _beside(traces, reference)
    if np.count_nonzero(tops) != 1 or len(beside) < FEWEST_BESIDE:
        return 0.0, 0.0
    first = 1 + int(np.argmax(tops))
    before, top, after = level[first - 1 : first + 2]
    around = levels_at(traces, focus, beside, optical_m).max(axis=1)
    # Where nothing was buried some echo is the strongest, too, but no stronger than elsewhere.
    if top < STANDS_OUT * np.median(around):
        return 0.0, 0.0
    offset = 0.5 * (after - before) / max(2.0 * top - before - after, 1e-300)
    return float(top / np.median(level)), float(optical_m[first] + offset * OPTICAL_STEP_M)


def _refused(reason: Message, reference: BuriedReference) -> WrongDatasetError:
    return WrongDatasetError(
        Message(
            "the buried reference at x {x_mm:.0f} mm, y {y_mm:.0f} mm gives no permittivity: "
            "{reason}; check its place, or give the permittivity",
            x_mm=MM_PER_M * reference.x_m,
            y_mm=MM_PER_M * reference.y_m,
            reason=reason,
        ),
        fault=NOT_ALLOWED,
    )
