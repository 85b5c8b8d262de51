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
from typing import Iterator, Optional

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter

from gpr20_analysis import faults
from gpr20_analysis.dataset import (
    FREQUENCY,
    HEIGHT,
    POLARIZATION,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    X,
    Y,
    require,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message, numeral
from gpr20_survey.radar.depth import two_way_delay_s

# Of the sweep's step.
FREQUENCY_TOLERANCE = 1e-3
ROTATION_TOLERANCE_DEG = 0.5
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
    MEDIAN = "median"
    """Median of real and imaginary part: targets that fill less than half do not bias it."""
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
            fault=faults.INPUT,
        )
    measured = require(survey, S21, S21_DIMS)
    empty = require(reference, S21, S21_DIMS).mean([Y, X], skipna=True)
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
    cleaned: Optional[np.ndarray] = None
    if method is Background.MOVING:
        cleaned = s21 - _moving_mean(s21, present, width)
    elif method is Background.SURFACE:
        cleaned = _without_surface(survey, s21, present)
    if cleaned is None:
        average = _median if method is Background.MEDIAN else _mean
        cleaned = s21 - average(s21, present)[:, None, None, :]
    return survey.assign({S21: measured.copy(data=cleaned)})


def _mean(s21: np.ndarray, present: np.ndarray) -> np.ndarray:
    """Return the mean trace of each polarization (polarization, frequency)."""
    sums = np.where(present[..., None], s21, 0.0).sum(axis=2).sum(axis=1)
    found: np.ndarray = sums / np.maximum(present.sum(axis=(1, 2)), 1)[:, None]
    return found


def _median(s21: np.ndarray, present: np.ndarray) -> np.ndarray:
    median = np.zeros((s21.shape[0], s21.shape[-1]), dtype=s21.dtype)
    for turn in np.flatnonzero(present.any((1, 2))):
        traces = s21[turn][present[turn]]
        median[turn] = np.median(traces.real, axis=0) + 1j * np.median(traces.imag, axis=0)
    return median


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


def _range(frequency_hz: np.ndarray) -> Message:
    return Message(
        "{start_hz:g} to {stop_hz:g} Hz, {count} points",
        start_hz=frequency_hz[0],
        stop_hz=frequency_hz[-1],
        count=len(frequency_hz),
    )


def _without_surface(
    survey: xr.Dataset, s21: np.ndarray, present: np.ndarray
) -> Optional[np.ndarray]:
    """Return the traces without coupling and surface echo, or None if the mean is as good.

    That is so if the heights are equal or not all known, if there are few traces, or if the
    surface echo does not follow the heights.
    """
    counts = present.sum(axis=(1, 2))
    held = np.flatnonzero(counts)
    if HEIGHT not in survey or not held.size:
        return None
    height_m = survey[HEIGHT].transpose(*SAMPLE_DIMS).values
    components = min(int(counts[held].min()) // TRACES_PER_COMPONENT, MOST_COMPONENTS)
    if components < 2 or not (height_m[present] > 0.0).all():
        return None
    if not min(np.std(height_m[turn][present[turn]]) for turn in held) > EQUAL_M:
        return None
    advance_s = np.zeros(present.shape)
    if ADVANCE in survey:
        advance_s = np.nan_to_num(survey[ADVANCE].transpose(*SAMPLE_DIMS).values)
    cleaned, is_fitted = np.empty_like(s21), False
    for turn in range(len(s21)):
        rows = _Components(
            survey[FREQUENCY].values, height_m[turn], advance_s[turn], present[turn], components
        )
        products = np.zeros((s21.shape[-1], components + 1, components + 1), s21.dtype)
        for columns, traces, own in zip(rows, s21[turn], present[turn]):
            both = np.concatenate([columns[:, own], traces[own][None]])
            products += np.einsum("axf,bxf->fab", both.conj(), both)
        factors = _fitted(products, int(counts[turn]))
        is_fitted |= factors is not None
        if factors is None:
            # A polarization without a surface echo that follows the heights gets the mean.
            factors = np.zeros((s21.shape[-1], components), dtype=np.complex128)
            factors[:, 0] = products[:, 0, -1] / max(counts[turn], 1)
        for row, columns in enumerate(rows):
            cleaned[turn, row] = s21[turn, row] - np.einsum("axf,fa->xf", columns, factors)
    return cleaned if is_fitted else None


class _Components:
    """Constant, surface and its change of one polarization, row by row (component, x, frequency).

    All rows at once would be three times the survey.
    """

    def __init__(
        self,
        frequency_hz: np.ndarray,
        height_m: np.ndarray,
        advance_s: np.ndarray,
        present: np.ndarray,
        count: int,
    ) -> None:
        known_m = height_m[present] if present.any() else np.ones(1)
        self._mean_m, self._spread_m = float(np.mean(known_m)), max(float(np.std(known_m)), EQUAL_M)
        self._height_m = np.where(present, height_m, self._mean_m)
        self._turn, self._advance_s, self._count = 2j * np.pi * frequency_hz, advance_s, count

    def __iter__(self) -> Iterator[np.ndarray]:
        for height_m, advance_s in zip(self._height_m[..., None], self._advance_s[..., None]):
            constant = np.exp(self._turn * advance_s)
            surface = constant * np.exp(-self._turn * two_way_delay_s(height_m))
            surface *= self._mean_m / height_m
            change = surface * (height_m - self._mean_m) / self._spread_m
            yield np.stack([constant, surface, change])[: self._count]


def _fitted(products: np.ndarray, traces: int) -> Optional[np.ndarray]:
    """Return the factors (frequency, component) of a polarization; None if they gain too little.

    Args:
        products: Of components and traces with one another, summed over the traces (frequency,
            component + 1, component + 1), of which the last row and column are the traces'.
        traces: Number of traces.
    """
    if traces == 0:
        return None
    among, with_traces = products[..., :-1, :-1], products[..., :-1, -1]
    factors = _solved(among, with_traces)
    energy = float(np.sum(products[..., -1, -1].real))
    explained = float(np.sum((factors * with_traces.conj()).real))
    by_mean = float(np.sum(np.abs(with_traces[..., 0]) ** 2 / among[..., 0, 0].real))
    chance = (factors.shape[-1] - 1) / traces
    enough = explained - by_mean > LEAST_GAIN * chance * (energy - by_mean)
    return factors if enough else None


def _solved(among: np.ndarray, with_traces: np.ndarray) -> np.ndarray:
    """Return the factors of least squares (..., component) from the products."""
    shares, vectors = np.linalg.eigh(among)
    held = shares > SMALLEST_SHARE * shares[..., -1:]
    inverse = np.where(held, 1.0 / np.where(held, shares, 1.0), 0.0)
    turned = np.swapaxes(vectors, -1, -2).conj() @ with_traces[..., None]
    solved: np.ndarray = (vectors @ (inverse[..., None] * turned))[..., 0]
    return solved
