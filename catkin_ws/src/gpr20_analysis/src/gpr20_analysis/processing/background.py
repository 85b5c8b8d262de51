"""Removal of what is the same at all positions: antenna coupling, echo of the surface."""

from __future__ import annotations

import enum
from typing import Tuple

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter

from gpr20_analysis import faults, lazy
from gpr20_analysis.dataset import (
    FREQUENCY,
    POLARIZATION,
    S21,
    S21_DIMS,
    X,
    Y,
    require,
    require_complete,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.surface_background import with_surface
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message, numeral

# Of the sweep's step.
FREQUENCY_TOLERANCE = 1e-3
ROTATION_TOLERANCE_DEG = 0.5
# Size of the part of a lazy survey of which a median is computed at once.
BAND_BYTES = 128 << 20


class Background(enum.Enum):
    """How the background is estimated, from complex data."""

    SURFACE = "surface"
    """Mean, and the echo of the surface at each recorded height."""
    MEAN = "mean"
    """Mean over all positions."""
    MEDIAN = "median"
    """Median of real and imaginary part: targets that fill less than half do not bias it."""
    MOVING = "moving"
    """Mean over a window around each position: follows a sloping surface."""
    SVD = "svd"
    """The strongest components of all traces: adapts to shape and strength."""


def subtract_coupling(survey: xr.Dataset, reference: xr.Dataset) -> xr.Dataset:
    """Subtract what the antennas receive without any target or ground.

    Args:
        survey: The survey.
        reference: A survey with the same sweep and rotations, measured towards the sky or an
            absorber; its mean over all positions is subtracted.

    Raises:
        WrongDatasetError: The reference is the survey itself, has another sweep, or lacks a
            rotation.
    """
    if (
        survey.attrs.get("survey_id")
        and reference.attrs.get("survey_id") == survey.attrs["survey_id"]
    ):
        raise WrongDatasetError(
            Message(
                "the reference is the survey itself, so echoes of the ground would be subtracted "
                "too; use a survey measured towards the sky, or the step background"
            ),
            fault=faults.INPUT,
        )
    measured = require(survey, S21, S21_DIMS)
    empty = require(reference, S21, S21_DIMS).mean([Y, X], skipna=True).compute()
    ours, theirs = survey[FREQUENCY].values, reference[FREQUENCY].values
    step_hz = abs(ours[-1] - ours[0]) / max(len(ours) - 1, 1)
    if ours.shape != theirs.shape or np.max(np.abs(ours - theirs)) > FREQUENCY_TOLERANCE * step_hz:
        raise WrongDatasetError(
            Message(
                "the reference was measured at {reference}, the survey at {survey}; measure the "
                "reference with the sweep of the survey",
                reference=_range(theirs),
                survey=_range(ours),
            ),
            fault=faults.INPUT,
        )
    for turn in survey[POLARIZATION].values:
        off_deg = np.abs(reference[POLARIZATION].values - turn)
        if not np.min(off_deg) <= ROTATION_TOLERANCE_DEG:
            raise WrongDatasetError(
                Message(
                    "the reference has no rotation {rotation_deg:g} deg, only {rotations} deg; "
                    "measure it with the rotations of the survey",
                    rotation_deg=turn,
                    rotations=tuple(map(numeral, reference[POLARIZATION].values)),
                ),
                fault=faults.INPUT,
            )
    matched = empty.sel({POLARIZATION: survey[POLARIZATION].values}, method="nearest")
    if not bool(np.all(np.isfinite(matched.values))):
        raise WrongDatasetError(
            Message("the reference has no usable sample at one of the rotations; measure it again"),
            fault=faults.INPUT,
        )
    return survey.assign({S21: measured - matched.values[:, None, None, :]})


def remove_background(
    survey: xr.Dataset, method: Background = Background.SURFACE, width: int = 11, rank: int = 1
) -> xr.Dataset:
    """Subtract the background of each polarization.

    Args:
        survey: The survey; missing samples stay missing and are ignored.
        method: How the background is estimated. With equal or unknown heights, or with fewer than
            20 traces, the surface is the mean.
        width: Width of the moving window along X and along Y, in positions, odd. It ends where the
            survey does: wider than that, or along the one row of a line, it is all of them.
        rank: Number of components that SVD removes.

    Raises:
        WrongDatasetError: Width or rank do not suit the survey.
        DamagedSurveyError: A sample is missing and the method is SVD.
    """
    measured = lazy.in_rows(require(survey, S21, S21_DIMS))
    if method is Background.SVD:
        require_complete(survey, Message("the background by SVD"))
        return survey.assign({S21: _without_strongest(measured, rank)})
    if method is Background.MOVING:
        return survey.assign({S21: _without_moving(measured, width)})
    if method is Background.SURFACE:
        cleaned = with_surface(survey, measured, _present(measured))
        if cleaned is not None:
            return survey.assign({S21: cleaned})
    background = _median(measured) if method is Background.MEDIAN else _mean(measured)
    return survey.assign({S21: measured - background})


def _present(measured: xr.DataArray) -> xr.DataArray:
    """Return which traces have finite values only, bool (polarization, y, x)."""
    present: xr.DataArray = xr.apply_ufunc(np.isfinite, measured, dask="allowed").all(FREQUENCY)
    return present


def _mean(measured: xr.DataArray) -> xr.DataArray:
    present = _present(measured)
    # Row by row, so that the last digit does not depend on the chunks.
    of_rows = measured.where(present, 0.0).sum(X, skipna=False)
    counts = present.sum([Y, X])
    if measured.chunks is not None:
        import dask  # its import takes 0.1 s

        of_rows, counts = dask.compute(of_rows, counts)
    return of_rows.sum(Y, skipna=False) / np.maximum(counts, 1)


def _median(measured: xr.DataArray) -> xr.DataArray:
    present = _present(measured).values
    median = np.zeros((measured.shape[0], measured.shape[-1]), dtype=measured.dtype)
    # A median needs all traces of a frequency, so lazy data are read band by band.
    count = measured.shape[-1]
    bands = 1 if measured.chunks is None else -(-measured[0].nbytes // BAND_BYTES)
    width = -(-count // bands)
    for turn in np.flatnonzero(present.any((1, 2))):
        for first in range(0, count, width):
            band = slice(first, first + width)
            traces = measured[turn, ..., band].values[present[turn]]
            median[turn, band] = np.median(traces.real, axis=0)
            median[turn, band] += 1j * np.median(traces.imag, axis=0)
    return xr.DataArray(median, dims=(POLARIZATION, FREQUENCY))


def _without_moving(measured: xr.DataArray, width: int) -> xr.DataArray:
    if width < 3 or width % 2 == 0:
        raise WrongDatasetError(
            Message(
                "the width of the moving window is {width}; it must be odd and at least 3",
                width=width,
            ),
            fault=NOT_ALLOWED,
        )
    # From the last position, so much reaches the first.
    down, across = (min(width, 2 * measured.sizes[axis] - 1) for axis in (Y, X))
    return lazy.with_neighbours(
        lambda rows: rows - _moving_mean(rows, (1, down, across, 1)), measured, down // 2
    )


def _moving_mean(rows: np.ndarray, widths: Tuple[int, ...]) -> np.ndarray:
    """Return the mean over a window around each position; missing traces are ignored."""
    present = np.isfinite(rows).all(axis=-1, keepdims=True)
    share = uniform_filter(present.astype(np.float64), widths, mode="constant")
    share = np.maximum(share, 0.5 / np.prod(widths))
    held = np.where(present, rows, 0.0)
    means: np.ndarray = uniform_filter(held, widths, mode="constant")
    means /= share
    return means


def _without_strongest(measured: xr.DataArray, rank: int) -> xr.DataArray:
    traces, frequencies = measured.sizes[Y] * measured.sizes[X], measured.sizes[FREQUENCY]
    if not 1 <= rank < min(traces, frequencies):
        raise WrongDatasetError(
            Message(
                "the rank is {rank}; it must be 1 to {most} for {traces} traces of {frequencies} "
                "frequencies",
                rank=rank,
                most=min(traces, frequencies) - 1,
                traces=traces,
                frequencies=frequencies,
            ),
            fault=NOT_ALLOWED,
        )
    return xr.concat(
        [_projected(measured.isel({POLARIZATION: [turn]}), rank) for turn in range(len(measured))],
        POLARIZATION,
    )


def _projected(measured: xr.DataArray, rank: int) -> xr.DataArray:
    """Return the traces of one polarization without their strongest components."""
    places = (0, 1, 2)
    # The components over frequency are eigenvectors of a matrix as small as the sweep.
    products = np.tensordot(measured.data.conj(), measured.data, axes=(places, places))
    _, vectors = np.linalg.eigh(np.asarray(products))
    strongest = vectors[:, -rank:]
    return xr.apply_ufunc(
        lambda rows: rows - rows @ strongest @ strongest.conj().T,
        measured,
        input_core_dims=[[FREQUENCY]],
        output_core_dims=[[FREQUENCY]],
        dask="parallelized",
        output_dtypes=[measured.dtype],
    )


def _range(frequency_hz: np.ndarray) -> Message:
    return Message(
        "{start_hz:g} to {stop_hz:g} Hz, {count} points",
        start_hz=frequency_hz[0],
        stop_hz=frequency_hz[-1],
        count=len(frequency_hz),
    )
