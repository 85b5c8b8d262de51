"""The delay of cables and antennas, fitted from the echo of the surface and the recorded heights.

The direct coupling between the antennas has the same delay at every position, the echo of the
surface moves with the height. Where the heights differ, the two are separated by that. Where they
do not, the echo of the surface is the last strong one in the mean of all traces, because the
coupling takes a shorter path and targets are not below most traces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import HEIGHT, S21, S21_DIMS, SAMPLE_DIMS, X, Y, require, usable
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.aligned_echo import SurfaceEcho
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message

SURFACE_DELAY = "surface_delay_s"
"""Attribute: median over the traces of the delay of the surface echo less that of twice the
recorded height [s], in the data as measured."""
FEWEST_TRACES, FEWEST_OVER_PLATE = 16, 5
"""Over fewer traces a target may look like the surface."""
# Enough for a median, and few enough for a check of every survey.
MOST_ROWS, MOST_COLUMNS = 8, 32
# Of the traces, those whose surface echo must be near the common one.
LEAST_SHARE = 0.6
NEIGHBOURS_ALIKE = 2.0
SIGMA_OF_MAD, MEDIAN_TO_MEAN = 1.4826, 1.2533


@dataclass(frozen=True)
class SurfaceFit:
    """The delay of cables and antennas by the echo of the surface.

    Attributes:
        delay_s: The delay [s].
        uncertainty_s: The delay is within this of the truth in 95 of 100 cases [s], if heights,
            separation and ground are as assumed.
        residual_s: Spread of the single traces, as a standard deviation [s].
        traces: Number of traces that were used.
        by_movement: Whether coupling and surface were separated by the differing heights.
    """

    delay_s: float
    uncertainty_s: float
    residual_s: float
    traces: int
    by_movement: bool


def fit_delay(
    survey: xr.Dataset,
    separation_m: float = 0.0,
    height_m: Optional[float] = None,
    plate: bool = False,
) -> SurfaceFit:
    """Fit the delay of cables and antennas to the surface echo of all traces.

    A constant error of the recorded heights cannot be distinguished from a delay; the fit
    contains it, and depths below the surface are right with it.

    Args:
        survey: The survey as measured, before any step.
        separation_m: Distance between the antennas [m].
        height_m: One antenna height for all traces instead of the recorded ones [m].
        plate: Whether the survey was measured over a metal plate, whose echo is the strongest.

    Raises:
        WrongDatasetError: The surface echo is not clear; the message says why.
    """
    measured = require(survey, S21, S21_DIMS)
    if ADVANCE in survey:
        raise WrongDatasetError(
            Message("time zero was set before, so the data no longer contain the delay to fit")
        )
    sweep = FrequencyGrid.of(survey)
    rows, columns = (
        spread(survey.sizes[axis], most) for axis, most in ((Y, MOST_ROWS), (X, MOST_COLUMNS))
    )
    chosen = survey.isel({Y: rows, X: columns})
    heights_m = require(chosen, HEIGHT, SAMPLE_DIMS).values
    if height_m is not None:
        heights_m = np.full(heights_m.shape, height_m)
    spectra = measured.isel({Y: rows, X: columns}).values
    known = usable(chosen).transpose(*SAMPLE_DIMS).values & np.isfinite(spectra).all(-1)
    known &= heights_m > 0.0
    fits: List[SurfaceEcho] = []
    reasons: List[Message] = []
    for turn in range(len(spectra)):
        path_m = _path_m(heights_m[turn][known[turn]], separation_m)
        try:
            fits.append(SurfaceEcho(spectra[turn][known[turn]], sweep, path_m, plate))
        except WrongDatasetError as error:
            reasons.append(error.message)
    if not fits:
        raise WrongDatasetError(
            Message(
                "the echo of the surface is not clear: {reason}; give a known delay with --delay",
                reason=reasons[0],
            ).reporting_only(NOT_ALLOWED)
        )
    return _combined(fits, FEWEST_OVER_PLATE if plate else FEWEST_TRACES)


def with_surface_delay(survey: xr.Dataset) -> xr.Dataset:
    """Return a survey with attribute `surface_delay_s` if its surface echo is clear."""
    if S21 not in survey or HEIGHT not in survey or SURFACE_DELAY in survey.attrs:
        return survey
    try:
        fit = fit_delay(survey)
    except WrongDatasetError:
        return survey  # Without a clear echo there is nothing to compare the heights with.
    return survey.assign_attrs({SURFACE_DELAY: fit.delay_s})


def _combined(fits: List[SurfaceEcho], fewest: int) -> SurfaceFit:
    delays_s = np.concatenate([one.delays_s for one in fits])
    found = np.isfinite(delays_s)
    count = int(np.count_nonzero(found))
    if found.size < fewest:
        raise WrongDatasetError(
            Message(
                "{count} traces with data and height are too few to find the echo of the surface; "
                "use at least {fewest}, or give --delay",
                count=found.size,
                fewest=fewest,
            ),
            fault=NOT_ALLOWED,
        )
    if count < LEAST_SHARE * found.size:
        raise WrongDatasetError(
            Message(
                "the echo of the surface is not clear: only {count} of {total} traces show it at "
                "their recorded height; give a known delay with --delay",
                count=count,
                total=found.size,
            ),
            fault=NOT_ALLOWED,
        )
    delay_s = float(np.median(delays_s[found]))
    residual_s = SIGMA_OF_MAD * float(np.median(np.abs(delays_s[found] - delay_s)))
    # Neighbouring traces see the same targets, so they count less than their number.
    of_median_s = MEDIAN_TO_MEAN * residual_s / np.sqrt(count / NEIGHBOURS_ALIKE)
    others_s = max(one.interference_s for one in fits)
    return SurfaceFit(
        delay_s=delay_s,
        uncertainty_s=float(2.0 * of_median_s + others_s),
        residual_s=residual_s,
        traces=count,
        by_movement=all(one.by_movement for one in fits),
    )


def _path_m(height_m: np.ndarray, separation_m: float) -> np.ndarray:
    """Return the path from one antenna over the surface to the other [m]."""
    return np.hypot(2.0 * height_m, separation_m)


def spread(count: int, most: int) -> np.ndarray:
    """Return evenly spread indices, all of them if there are no more than `most`."""
    return np.unique(np.round(np.linspace(0, count - 1, min(count, most))).astype(int))
