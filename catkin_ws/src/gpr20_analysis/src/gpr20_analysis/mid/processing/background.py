"""What does not change from place to place: coupling of the antennas, echo of the surface."""

from __future__ import annotations

import enum
from typing import Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.mid import row_blocks
from gpr20_analysis.mid.dataset import (
    FREQUENCY,
    POLARIZATION,
    S21,
    S21_DIMS,
    X,
    Y,
    require,
    require_complete,
)
from gpr20_analysis.mid.row_blocks import Array
from gpr20_analysis.mid.workers import slices

# Of the sweep's step.
FREQUENCY_TOLERANCE = 1e-3
ROTATION_TOLERANCE_DEG = 0.5
# Of a lazy survey, what a median is taken of at once.
BAND_BYTES = 128 << 20
# Of a moving window, whose running sums take several times the memory of what they are made of.
FREQUENCIES_AT_ONCE = 128


class Background(enum.Enum):
    """How the background is estimated; always on complex data."""

    MEAN = "mean"
    """Mean over all positions."""
    MEDIAN = "median"
    """Median of real and imaginary part: targets that fill less than half do not bias it."""
    MOVING = "moving"
    """Mean over a window of positions about each: follows a surface that rises."""
    SVD = "svd"
    """The strongest components of all traces: follows shape and strength."""


def subtract_coupling(survey: xr.Dataset, reference: xr.Dataset) -> xr.Dataset:
    """Subtract what the antennas receive with nothing before them.

    Args:
        survey: The survey.
        reference: A survey with the same sweep and rotations, made with the antennas towards the
            sky or an absorber; its mean over all positions is subtracted.

    Raises:
        WrongDatasetError: The reference is the survey itself, has another sweep, or lacks a
            rotation.
    """
    if (
        survey.attrs.get("survey_id")
        and reference.attrs.get("survey_id") == survey.attrs["survey_id"]
    ):
        raise WrongDatasetError(
            "the reference is the survey itself: what the ground sends back would be taken for "
            "coupling; name a survey made towards the sky, or take the step background"
        )
    measured = require(survey, S21, S21_DIMS)
    empty = require(reference, S21, S21_DIMS).mean([Y, X], skipna=True).compute()
    ours, theirs = survey[FREQUENCY].values, reference[FREQUENCY].values
    step_hz = abs(ours[-1] - ours[0]) / max(len(ours) - 1, 1)
    if ours.shape != theirs.shape or np.max(np.abs(ours - theirs)) > FREQUENCY_TOLERANCE * step_hz:
        raise WrongDatasetError(
            f"the reference was measured at {_range(theirs)}, the survey at {_range(ours)}; "
            "measure the reference with the sweep of the survey"
        )
    for turn in survey[POLARIZATION].values:
        off_deg = np.abs(reference[POLARIZATION].values - turn)
        if not np.min(off_deg) <= ROTATION_TOLERANCE_DEG:
            raise WrongDatasetError(
                f"the reference has no rotation {turn:g} deg, only "
                f"{', '.join(f'{one:g}' for one in reference[POLARIZATION].values)}"
            )
    matched = empty.sel({POLARIZATION: survey[POLARIZATION].values}, method="nearest")
    if not bool(np.all(np.isfinite(matched.values))):
        raise WrongDatasetError("the reference has no usable sample at one of the rotations")
    return survey.assign({S21: measured - matched.values[:, None, None, :]})


def remove_background(
    survey: xr.Dataset, method: Background = Background.MEAN, width: int = 11, rank: int = 1
) -> xr.Dataset:
    """Subtract the background of each polarization.

    Args:
        survey: The survey; missing samples stay missing and do not count.
        method: How the background is estimated.
        width: Positions along X and along Y that a moving window spans, odd.
        rank: How many components SVD takes away.

    Raises:
        WrongDatasetError: Width or rank do not suit the survey.
        DamagedSurveyError: SVD was asked for and a sample is missing.
    """
    measured = row_blocks.in_rows(require(survey, S21, S21_DIMS))
    if method is Background.SVD:
        require_complete(survey, "the background by SVD")
    clean = {
        Background.MEAN: lambda volume: volume - _mean(volume),
        Background.MEDIAN: lambda volume: volume - _median(volume),
        Background.MOVING: lambda volume: _without_moving(volume, width),
        Background.SVD: lambda volume: _without_strongest(volume, rank),
    }[method]
    cleaned = row_blocks.stack([clean(volume) for volume in measured.data])
    return survey.assign({S21: measured.copy(data=cleaned)})


def _mean(volume: Array) -> np.ndarray:
    sums, counts = zip(*row_blocks.gather(_row_sums_and_count, volume))
    # Row by row, so that the last digit does not depend on how the rows lie in blocks.
    mean: np.ndarray = np.concatenate(sums).sum(axis=0) / max(sum(counts), 1)
    return mean


def _row_sums_and_count(volume: np.ndarray) -> Tuple[np.ndarray, int]:
    present = _present(volume)
    return np.where(present, volume, 0.0).sum(axis=1), np.count_nonzero(present)


def _median(volume: Array) -> np.ndarray:
    present = np.concatenate(row_blocks.gather(_present, volume))[..., 0]
    found = np.zeros(volume.shape[-1], dtype=volume.dtype)
    if not np.any(present):
        return found
    # A median needs all traces of a frequency, so lazy ones are gone through band by band.
    bands = -(-volume.nbytes // BAND_BYTES) if row_blocks.is_lazy(volume) else 1
    for band in slices(volume.shape[-1], bands):
        traces = np.asarray(volume[..., band])[present]
        found[band] = np.median(traces.real, axis=0) + 1j * np.median(traces.imag, axis=0)
    return found


def _present(volume: np.ndarray) -> np.ndarray:
    """Return which traces hold numbers throughout, bool (y, x, 1)."""
    return np.all(np.isfinite(volume), axis=-1, keepdims=True)


def _without_moving(volume: Array, width: int) -> Array:
    smaller = min(size for size in volume.shape[:2])
    if width < 3 or width % 2 == 0 or width > 2 * smaller + 1:
        raise WrongDatasetError(
            f"the moving window spans {width} positions; it must be odd, 3 or more, and at most "
            f"{2 * smaller + 1} here"
        )
    return row_blocks.each_with_neighbours(
        lambda rows: rows - _moving(rows, width), volume, width // 2
    )


def _moving(volume: np.ndarray, width: int) -> np.ndarray:
    present = _present(volume)
    counts = np.maximum(_window_sum(present.astype(np.float64), width), 1.0)
    means = np.empty_like(volume)
    for band in slices(volume.shape[-1], -(-volume.shape[-1] // FREQUENCIES_AT_ONCE)):
        held = np.where(present, volume[..., band], 0.0)
        means[..., band] = _window_sum(held, width) / counts
    return means


def _window_sum(volume: np.ndarray, width: int) -> np.ndarray:
    """Sum over a window about each position; positions outside count nothing."""
    for axis in (0, 1):
        before = np.zeros_like(np.take(volume, [0], axis=axis))
        running = np.concatenate([before, np.cumsum(volume, axis=axis)], axis=axis)
        first, after = _bounds(volume.shape[axis], width)
        volume = np.take(running, after, axis=axis) - np.take(running, first, axis=axis)
    return volume


def _bounds(count: int, width: int) -> Tuple[np.ndarray, np.ndarray]:
    places = np.arange(count)
    return np.maximum(places - width // 2, 0), np.minimum(places + width // 2 + 1, count)


def _without_strongest(volume: Array, rank: int) -> Array:
    traces, frequencies = volume.shape[0] * volume.shape[1], volume.shape[2]
    if not 1 <= rank < min(traces, frequencies):
        raise WrongDatasetError(
            f"the rank is {rank}; it must be 1..{min(traces, frequencies) - 1} for {traces} "
            f"traces of {frequencies} frequencies"
        )
    # The components over frequency are eigenvectors of a matrix as small as the sweep.
    _, vectors = np.linalg.eigh(row_blocks.total(_products, volume))
    strongest = vectors[:, -rank:]
    return row_blocks.each(lambda rows: rows - rows @ strongest @ strongest.conj().T, volume)


def _products(volume: np.ndarray) -> np.ndarray:
    matrix = volume.reshape(-1, volume.shape[-1])
    return matrix.conj().T @ matrix


def _range(frequency_hz: np.ndarray) -> str:
    return f"{frequency_hz[0]:g}..{frequency_hz[-1]:g} Hz, {len(frequency_hz)} points"
