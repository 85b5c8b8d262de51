"""Default ranges of figures: the delays and magnitudes where the ground can be seen."""

from __future__ import annotations

from typing import Optional

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import DELAY, HEIGHT
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.read.survey_attributes import ANTENNA_DELAY
from gpr20_survey.radar.depth import two_way_delay_s
from gpr20_survey.radar.frequency_to_delay import decibels

# Without other values: depth of a default image, moist soil, antennas as high as usual.
DEEPEST_M, PERMITTIVITY, HEIGHT_M = 0.3, 9.0, 0.3
MARGIN_S = 0.5e-9
RANGE_STEP_DB, SMALLEST_RANGE_DB, LARGEST_RANGE_DB = 5.0, 20.0, 50.0
# A few disturbed traces are brighter than the scale, instead of hiding all others.
PART_OF_TRACES = 0.95
MOST_VALUES = 200_000


def surface_delay_s(data: xr.Dataset) -> Optional[float]:
    """Return the mean two-way delay of the surface.

    Args:
        data: A survey, or its A-scans.

    Returns:
        The delay [s]; None if no height is known.
    """
    antennas_s = float(data.attrs.get(ANTENNA_DELAY, 0.0))
    if ADVANCE in data:
        return antennas_s
    heights_m = data[HEIGHT].values if HEIGHT in data else np.array([])
    known = heights_m[np.isfinite(heights_m)]
    return antennas_s + two_way_delay_s(float(known.mean())) if known.size else None


def last_delay_s(
    data: xr.Dataset, deepest_m: float = DEEPEST_M, permittivity: Optional[float] = None
) -> float:
    """Return the delay at which figures end: a little after the echo of the deepest layer.

    Args:
        data: A survey, or its A-scans.
        deepest_m: Depth of the layer [m].
        permittivity: Relative permittivity of the soil; None: that of moist soil.

    Returns:
        The two-way delay [s].
    """
    surface_s = surface_delay_s(data)
    if surface_s is None:
        surface_s = float(data.attrs.get(ANTENNA_DELAY, 0.0)) + two_way_delay_s(HEIGHT_M)
    soil_s = two_way_delay_s(deepest_m * np.sqrt(permittivity or PERMITTIVITY))
    return float(surface_s + soil_s + MARGIN_S)


def until(
    in_time: xr.Dataset, last_s: Optional[float] = None, permittivity: Optional[float] = None
) -> xr.Dataset:
    """Return A-scans up to a delay.

    Args:
        in_time: Dataset with `a_scan`.
        last_s: The last delay [s]; `math.inf` keeps all; None: `last_delay_s`.
        permittivity: For `last_delay_s`.

    Returns:
        The Dataset with at least two delays.
    """
    end_s = last_delay_s(in_time, permittivity=permittivity) if last_s is None else last_s
    count = int(np.searchsorted(in_time[DELAY].values, end_s, side="right"))
    return in_time.isel({DELAY: slice(None, max(count, 2))})


def brightest(traces: np.ndarray) -> float:
    """Return the magnitude of 0 dB: the largest, except for a few disturbed traces.

    Args:
        traces: Traces along the last axis; NaN where there is none.

    Returns:
        The magnitude; 0 if there is none.
    """
    magnitudes = np.abs(traces).reshape(-1, traces.shape[-1])
    largest = magnitudes[np.isfinite(magnitudes).all(axis=1)].max(axis=1, initial=0.0)
    return float(np.quantile(largest, PART_OF_TRACES, method="lower")) if largest.size else 0.0


def range_db(magnitudes: np.ndarray, reference: float) -> float:
    """Return how far below 0 dB the colours reach, so that half of the values are darkest.

    Args:
        magnitudes: Magnitudes; NaN where there is none.
        reference: Magnitude of 0 dB.

    Returns:
        A positive number [dB].
    """
    known = magnitudes[np.isfinite(magnitudes)]
    some = known[:: max(1, known.size // MOST_VALUES)]
    middle = float(np.median(some)) if some.size else 0.0
    if not (middle > 0.0 and reference > 0.0):
        return LARGEST_RANGE_DB
    steps = np.ceil(decibels(reference / middle) / RANGE_STEP_DB)
    return float(np.clip(RANGE_STEP_DB * steps, SMALLEST_RANGE_DB, LARGEST_RANGE_DB))
