"""Removal of what is the same at all positions: antenna coupling, echo of the surface.

Coupling stays at its delay, while the surface echo moves with the height, so no mean over traces of
different heights contains it. At each frequency the background is the sum of a constant, the echo
of a level surface at each recorded height, and a change of that echo with the height (which takes
up its strength, its delay and errors of the height's scale to the first order). The three factors
are fitted to all traces by least squares.

The noise of the height sensor is no reason to remove more than the mean. So the echo is fitted
only if that removes clearly more than components without a meaning would by chance, of what the
mean leaves.
"""

from __future__ import annotations

import enum
from typing import Optional

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter

from gpr20_analysis import errors
from gpr20_analysis.dataset import (
    FREQUENCY,
    HEIGHT,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    X,
    Y,
    require,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.processing.sweep import matched
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import two_way_delay_s

# A background of as many components as traces would be the traces themselves.
TRACES_PER_COMPONENT = 10
MOST_COMPONENTS = 3
# Times the share that a component without a meaning removes, which is 1 / traces.
LEAST_GAIN = 5.0
# Standard deviation of heights that differ by rounding only.
EQUAL_M = 1e-6
# Components whose share is smaller are the same to within the rounding.
SMALLEST_SHARE = 1e-9


class Background(enum.Enum):
    """How the background is estimated, from complex data."""

    SURFACE = "surface"
    """Mean, and the echo of the surface at each recorded height."""
    MEAN = "mean"
    """Mean over all positions."""
    MOVING = "moving"
    """Mean over a window around each position: follows a sloping surface."""


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
            fault=errors.INPUT,
        )
    measured = require(survey, S21, S21_DIMS)
    empty = require(matched(reference, survey), S21, S21_DIMS).mean([Y, X], skipna=True)
    if not bool(np.all(np.isfinite(empty.values))):
        raise WrongDatasetError(
            Message("the reference has no usable sample at one of the rotations; measure it again"),
            fault=errors.INPUT,
        )
    return survey.assign({S21: measured - empty.values[:, None, None, :]})


def remove_background(
    survey: xr.Dataset, method: Background = Background.SURFACE, width: int = 11
) -> xr.Dataset:
    """Subtract the background of each polarization.

    Args:
        survey: The survey; missing samples stay missing and are ignored.
        method: How the background is estimated. With equal or unknown heights, or with fewer than
            20 traces, the surface is the mean.
        width: Width of the moving window along X and along Y, in positions, odd. It ends where the
            survey does: wider than that, or along the one row of a line, it is all of them.

    Raises:
        WrongDatasetError: The width is not allowed.
    """
    measured = require(survey, S21, S21_DIMS)
    s21 = measured.values
    present = np.isfinite(s21).all(axis=-1)
    if method is Background.MOVING:
        cleaned = s21 - _moving_mean(s21, present, width)
    else:
        counts = np.maximum(np.count_nonzero(present, axis=(1, 2)), 1)[:, None]
        average = np.sum(s21, axis=(1, 2), where=present[..., None]) / counts
        cleaned = s21 - average[:, None, None, :]
    if method is Background.SURFACE and HEIGHT in survey:
        advance_s = np.zeros(present.shape)
        if ADVANCE in survey:
            advance_s = np.nan_to_num(survey[ADVANCE].transpose(*SAMPLE_DIMS).values)
        turn = 2j * np.pi * survey[FREQUENCY].values
        heights_m = survey[HEIGHT].transpose(*SAMPLE_DIMS).values
        for number, one in enumerate(zip(s21, present, heights_m, advance_s)):
            fitted = _without_surface(*one, turn)
            if fitted is not None:
                cleaned[number] = fitted
    return survey.assign({S21: measured.copy(data=cleaned)})


def _moving_mean(s21: np.ndarray, present: np.ndarray, width: int) -> np.ndarray:
    """Return the mean over a window around each position; missing traces are ignored."""
    if width < 3 or width % 2 == 0:
        raise WrongDatasetError(
            Message(
                "the width of the moving window is {width}; it must be odd and at least 3",
                width=width,
            ),
            fault=NOT_ALLOWED,
        )
    # From the last position, so much reaches the first.
    down, across = (min(width, 2 * count - 1) for count in s21.shape[1:3])
    widths = (1, down, across, 1)
    share = uniform_filter(present[..., None].astype(np.float64), widths, mode="constant")
    share = np.maximum(share, 0.5 / np.prod(widths))
    held = np.where(present[..., None], s21, 0.0)
    means: np.ndarray = uniform_filter(held, widths, mode="constant")
    means /= share
    return means


def _without_surface(
    s21: np.ndarray,
    present: np.ndarray,
    height_m: np.ndarray,
    advance_s: np.ndarray,
    turn: np.ndarray,
) -> Optional[np.ndarray]:
    """Return the traces of one polarization without coupling and surface echo.

    None if the mean is as good: if the heights are equal or not all known, if there are few traces,
    or if the surface echo does not follow the heights.

    Args:
        s21: Spectra (y, x, frequency).
        present: Which are not missing (y, x).
        height_m: Heights (y, x) [m].
        advance_s: Delays that were removed before [s].
        turn: 2j pi times the frequencies [Hz].
    """
    known_m = height_m[present]
    count = len(known_m)
    components = min(count // TRACES_PER_COMPONENT, MOST_COMPONENTS)
    if components < 2 or not (known_m > 0.0).all() or not np.std(known_m) > EQUAL_M:
        return None
    mean_m, spread_m = float(np.mean(known_m)), float(np.std(known_m))
    height_m = np.where(present, height_m, mean_m)[..., None]

    # Row by row: all at once would be three times the survey.
    def columns(row: int) -> np.ndarray:
        """Return constant, surface and its change (component, x, frequency)."""
        constant = np.exp(turn * advance_s[row, :, None])
        surface = constant * np.exp(-turn * two_way_delay_s(height_m[row]))
        surface *= mean_m / height_m[row]
        change = surface * (height_m[row] - mean_m) / spread_m
        return np.stack([constant, surface, change])[:components]

    # Of components and traces with one another, summed over the traces; the traces are the last.
    products = np.zeros((s21.shape[-1], components + 1, components + 1), s21.dtype)
    for row, own in enumerate(present):
        both = np.concatenate([columns(row)[:, own], s21[row][own][None]])
        products += np.einsum("axf,bxf->fab", both.conj(), both)
    among, with_traces = products[..., :-1, :-1], products[..., :-1, -1]
    inverse = np.linalg.pinv(among, rcond=SMALLEST_SHARE, hermitian=True)
    factors = (inverse @ with_traces[..., None])[..., 0]
    energy = float(np.sum(products[..., -1, -1].real))
    explained = float(np.sum((factors * with_traces.conj()).real))
    by_mean = float(np.sum(np.abs(with_traces[..., 0]) ** 2 / among[..., 0, 0].real))
    chance = (components - 1) / count
    if not explained - by_mean > LEAST_GAIN * chance * (energy - by_mean):
        return None
    return np.stack(
        [one - np.einsum("axf,fa->xf", columns(row), factors) for row, one in enumerate(s21)]
    )
