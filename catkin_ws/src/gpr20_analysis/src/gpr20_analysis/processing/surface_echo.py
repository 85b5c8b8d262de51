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
import scipy.fft
import xarray as xr

from gpr20_analysis.dataset import HEIGHT, S21, S21_DIMS, SAMPLE_DIMS, X, Y, require, usable
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans, steps_to_top
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import (
    SPEED_OF_LIGHT_M_S,
    Window,
    delay_kernel,
    one_way_path_m,
    phase_advance,
)

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
PADDING = 4
# Delays beyond the path by the height, between which the surface echo may lie [s]. What is earlier
# may be the coupling, unless it moves with the height.
EARLIEST_S, EARLIEST_MOVING_S, LATEST_S = -0.07e-9, -0.7e-9, 40e-9
# Levels relative to the strongest echo. The last echo above the first is the surface; over a
# plate, a second echo above the other makes the first ambiguous.
LAST_STRONG, SECOND_OF_PLATE = 10.0 ** (-20.0 / 20.0), 10.0 ** (-3.0 / 20.0)
# Of the median of the mean trace, which noise exceeds 3 times among 500 values.
CLEAR = 6.0
# Of the root mean square over the traces: an echo that is the same in all of them has 1. Errors of
# the heights blur an echo that moves, but a target does not move with the heights.
COMMON, COMMON_MOVING = 0.9, 0.6
FEWEST_FOR_MOVEMENT = 8
# Share of what differs between the traces that the movement of the surface must explain.
EXPLAINED = 0.5
# Share of the movement's largest variance below which a frequency does not separate.
LEAST_VARIANCE = 0.02
# Of the level by which the movement explains the differences, what all traces must show there.
LEAST_SHOWN = 0.5
# A single strong echo is the coupling if a later one of at least this level follows, further away
# than the sidelobes of the first [resolution].
WEAK_SURFACE, FROM_SIDELOBES = 10.0 ** (-35.0 / 20.0), 3.2
# Heights that differ by more than this (standard deviation) must move the surface echo [m].
SENSOR_NOISE_M = 0.006
# Strong echoes that all traces have in common: the coupling and the surface.
MOST_STRONG = 2
# How far an echo of the same level moves another one, relative to the resolution.
PULL = 0.9
SMALLEST_S = 1e-12
STEPS_NEAR = 24


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
    if ADVANCE in survey:
        raise WrongDatasetError(
            Message("time zero was set before, so the data no longer contain the delay to fit")
        )
    sweep = FrequencyGrid.of(survey)
    chosen = thinned(survey)
    heights_m = require(chosen, HEIGHT, SAMPLE_DIMS).values
    if height_m is not None:
        heights_m = np.full(heights_m.shape, height_m)
    spectra = chosen[S21].transpose(*S21_DIMS).values
    known = usable(chosen).transpose(*SAMPLE_DIMS).values & np.isfinite(spectra).all(-1)
    known &= heights_m > 0.0
    found: List[_CommonEchoes] = []
    reasons: List[Message] = []
    for own, own_m, present in zip(spectra, heights_m, known):
        path_s = np.hypot(2.0 * own_m[present], separation_m) / SPEED_OF_LIGHT_M_S
        try:
            found.append(_surface_echo(own[present], sweep, path_s, plate))
        except WrongDatasetError as error:
            reasons.append(error.message)
    if not found:
        raise WrongDatasetError(
            Message(
                "the echo of the surface is not clear: {reason}; give a known delay with --delay",
                reason=reasons[0],
            ).reporting_only(NOT_ALLOWED)
        )
    delays_s = np.concatenate([one.delays_s() for one in found])
    clear = np.isfinite(delays_s)
    count = int(np.count_nonzero(clear))
    fewest = FEWEST_OVER_PLATE if plate else FEWEST_TRACES
    if delays_s.size < fewest or count < LEAST_SHARE * delays_s.size:
        raise WrongDatasetError(
            Message(
                "the echo of the surface is not clear: {count} of {total} traces show it at their "
                "recorded height; use at least {fewest}, of which {share:.0f} % show it, or give "
                "--delay",
                count=count,
                total=delays_s.size,
                fewest=fewest,
                share=100.0 * LEAST_SHARE,
            ),
            fault=NOT_ALLOWED,
        )
    delay_s = float(np.median(delays_s[clear]))
    residual_s = SIGMA_OF_MAD * float(np.median(np.abs(delays_s[clear] - delay_s)))
    # Neighbouring traces see the same targets, so they count less than their number.
    of_median_s = MEDIAN_TO_MEAN * residual_s / np.sqrt(count / NEIGHBOURS_ALIKE)
    return SurfaceFit(
        delay_s=delay_s,
        uncertainty_s=float(2.0 * of_median_s + max(one.interference_s() for one in found)),
        residual_s=residual_s,
        traces=count,
        by_movement=all(one.by_movement for one in found),
    )


def with_surface_delay(survey: xr.Dataset) -> xr.Dataset:
    """Return a survey with attribute `surface_delay_s` if its surface echo is clear."""
    if S21 not in survey or HEIGHT not in survey or SURFACE_DELAY in survey.attrs:
        return survey
    try:
        fit = fit_delay(survey)
    except WrongDatasetError:
        return survey  # Without a clear echo there is nothing to compare the heights with.
    return survey.assign_attrs({SURFACE_DELAY: fit.delay_s})


def thinned(survey: xr.Dataset) -> xr.Dataset:
    """Return at most 8 x 32 evenly spread positions of a survey."""
    rows, columns = (
        np.unique(np.round(np.linspace(0, count - 1, min(count, most))).astype(int))
        for count, most in ((survey.sizes[Y], MOST_ROWS), (survey.sizes[X], MOST_COLUMNS))
    )
    return survey.isel({Y: rows, X: columns})


def _surface_echo(
    spectra: np.ndarray, sweep: FrequencyGrid, path_s: np.ndarray, plate: bool
) -> _CommonEchoes:
    """Find the echo of the surface in the spectra (trace, frequency) of one polarization.

    Args:
        spectra: Spectra.
        sweep: Their frequencies.
        path_s: Delay from one antenna over the surface to the other in air, for each trace [s].
        plate: Whether the surface is a metal plate, with the strongest echo.

    Raises:
        WrongDatasetError: It is not clear; the message says why.
    """
    if not np.any(spectra):
        raise WrongDatasetError(Message("no trace has data and a height"))
    if sweep.resolution_s > 0.5 * float(np.median(path_s)):
        raise WrongDatasetError(
            Message(
                "a band of {band_hz:g} Hz does not separate it from the coupling of the "
                "antennas; use a wider band",
                band_hz=1.0 / sweep.resolution_s,
            )
        )
    tried = _moving(spectra, sweep, path_s, plate)
    # Recorded heights that differ only by the noise of their sensor would blur the echo.
    for unmoved_s in [] if tried else [np.zeros(len(path_s)), path_s - np.median(path_s)]:
        moved = spectra * phase_advance(sweep.frequency_hz, path_s - unmoved_s)
        common = moved.mean(axis=0)
        tried.append(_CommonEchoes(moved, common, sweep, path_s, unmoved_s, False, plate))
    best = max(tried, key=lambda one: float(one.level[one.surface]))
    reason = best.unclear()
    if reason is not None:
        raise WrongDatasetError(reason)
    return best


class _CommonEchoes:
    """Traces whose surface echoes lie at one delay, and the echoes that all have in common.

    Attributes:
        by_movement: Whether coupling and surface were separated by the differing heights.
        level: Magnitude of each echo in common, ascending by the delay.
        surface: Place of that of the surface.
    """

    def __init__(
        self,
        spectra: np.ndarray,
        common: np.ndarray,
        sweep: FrequencyGrid,
        path_s: np.ndarray,
        unmoved_s: np.ndarray,
        by_movement: bool,
        plate: bool,
    ) -> None:
        """Find the echoes.

        Args:
            spectra: Complex spectra (trace, frequency).
            common: Spectrum of what they have in common.
            sweep: The frequencies.
            path_s: Delay over the surface in air, for each trace [s].
            unmoved_s: Delay by which each was not moved although its height says so [s].
            by_movement: Whether coupling and surface were separated by the differing heights.
            plate: Whether the surface is a metal plate.
        """
        self._spectra, self._common, self._sweep = spectra, common, sweep
        self._unmoved_s, self.by_movement, self._plate = unmoved_s, by_movement, plate
        magnitude = _magnitude(common, sweep)
        singles = np.sqrt(np.mean(_magnitude(spectra, sweep) ** 2, axis=0))
        shared = _magnitude(spectra.mean(axis=0), sweep) if by_movement else magnitude
        is_top = (magnitude >= np.roll(magnitude, 1)) & (magnitude > np.roll(magnitude, -1))
        places = np.flatnonzero(is_top)
        # Delays repeat: what seems late by almost the whole period is early.
        period_s = sweep.unambiguous_s
        earliest_s = -float(np.median(path_s)) - sweep.resolution_s
        delay_s = places * (period_s / len(magnitude))
        delay_s = (delay_s - earliest_s) % period_s + earliest_s
        places = places[np.argsort(delay_s)]
        self._delay_s, self.level = np.sort(delay_s), magnitude[places]
        self._coherence = (shared / np.maximum(singles, 1e-300))[places]
        self._floor = float(np.median(magnitude))
        common_level = np.where(self._coherence >= COMMON, self.level, 0.0)
        if not np.any(common_level):
            common_level = np.where(self.level == self.level.max(), self.level, 0.0)
        self._strong = np.flatnonzero(common_level >= LAST_STRONG * common_level.max())
        is_strongest = by_movement or plate
        self.surface = int(np.argmax(self.level) if is_strongest else self._strong[-1])

    def unclear(self) -> Optional[Message]:
        """Return why the echo may not be that of the surface; None: it is."""
        level, delay_s = self.level[self.surface], self._delay_s[self.surface]
        if not level > CLEAR * self._floor:
            return Message("no echo rises above the noise in the mean of all traces")
        if not self._coherence[self.surface] >= (COMMON_MOVING if self.by_movement else COMMON):
            return Message(
                "the traces have no echo in common; fit the delay to the survey as measured, "
                "before its background is removed"
            )
        second = np.max(np.delete(self.level, self.surface), initial=0.0)
        if self._plate and not self.by_movement and second > SECOND_OF_PLATE * level:
            return Message(
                "the echo of the plate is not stronger than the coupling of the antennas; "
                "measure the plate at a smaller height"
            )
        earliest_s = EARLIEST_MOVING_S if self.by_movement else EARLIEST_S
        if not earliest_s <= delay_s <= LATEST_S:
            return Message(
                "the last strong echo of all traces is {delay_ns:.2f} ns later than the "
                "heights say; {earliest_ns:g} to {latest_ns:g} ns are allowed",
                delay_ns=delay_s * 1e9,
                earliest_ns=earliest_s * 1e9,
                latest_ns=LATEST_S * 1e9,
            )
        if self.by_movement or self._plate:
            return None
        spread_m = one_way_path_m(float(np.std(self._unmoved_s)))
        if spread_m > SENSOR_NOISE_M:
            return Message(
                "the heights differ by {spread_mm:.0f} mm (standard deviation), but the echo "
                "that all traces have in common does not move with them",
                spread_mm=1e3 * spread_m,
            )
        # A single strong echo is the coupling if weaker ones follow.
        begin_s = self._delay_s[self._strong[-1]] + FROM_SIDELOBES * self._sweep.resolution_s
        weak = (self.level > WEAK_SURFACE * self.level.max()) & (self._coherence >= COMMON)
        hidden = int(np.count_nonzero(weak & (self._delay_s > begin_s)))
        count = len(self._strong)
        if count > MOST_STRONG or (count == 1 and hidden):
            return Message(
                "all traces have {count} strong echoes in common, so it is not known which is "
                "the surface; measure at different heights, or over a metal plate",
                count=count if count > 1 else count + hidden,
            )
        return None

    def delays_s(self) -> np.ndarray:
        """Return the delay of the echo of each trace beyond its path; NaN if it is not near [s]."""
        return self._near(self._spectra) - self._unmoved_s

    def interference_s(self) -> float:
        """Return how much other echoes may move that of the surface in all traces [s]."""
        away_s = np.delete(self._delay_s, self.surface) - self._delay_s[self.surface]
        turns = phase_advance(self._sweep.frequency_hz, away_s)
        share = np.abs(turns @ Window.HANN.shares(self._sweep.count))
        others = np.delete(self.level, self.surface)
        # What is below the noise is not an echo; the spread of the traces contains it.
        others = np.where(others > CLEAR * self._floor, others, 0.0) / self.level[self.surface]
        pulled_s = PULL * self._sweep.resolution_s * float(np.sum(share * others))
        # Where echoes are merged, the delay depends on the window.
        found_s = np.array([self._near(self._common[None], one)[0] for one in Window])
        found_s = found_s[np.isfinite(found_s)]
        return SMALLEST_S + pulled_s + (float(np.ptp(found_s)) if found_s.size else 0.0)

    def _near(self, spectra: np.ndarray, window: Window = Window.HANN) -> np.ndarray:
        """Return the delay of the strongest value near the surface [s]; NaN at the edge."""
        step_s = self._sweep.resolution_s / STEPS_NEAR
        near_s = self._delay_s[self.surface] + step_s * np.arange(-STEPS_NEAR, STEPS_NEAR + 1)
        level = np.abs(spectra @ delay_kernel(self._sweep.frequency_hz, near_s, window))
        top = np.argmax(level, axis=1)
        at = np.clip(top, 1, len(near_s) - 2)
        return np.where(top == at, near_s[at] + step_s * steps_to_top(level, at), np.nan)


def _moving(
    spectra: np.ndarray, sweep: FrequencyGrid, path_s: np.ndarray, plate: bool
) -> List[_CommonEchoes]:
    """Return what moves with the heights; empty if that does not explain what differs.

    Each trace is modelled as one spectrum that all have in common, the coupling, and one that
    moves with the height, the surface. By least squares, the second is the covariance of
    traces and movement divided by the variance of the movement.
    """
    back = phase_advance(sweep.frequency_hz, path_s)
    moving = back.conj() * (np.mean(path_s) / path_s[:, None])
    mean, mean_moving = spectra.mean(axis=0), moving.mean(axis=0)
    changes, movement = spectra - mean, moving - mean_moving
    covariance = np.mean(changes * movement.conj(), axis=0)
    variance = np.mean(np.abs(movement) ** 2, axis=0)
    left = changes - covariance / np.maximum(variance, 1e-12) * movement
    explained = 1.0 - np.sum(np.abs(left) ** 2) / max(np.sum(np.abs(changes) ** 2), 1e-300)
    if len(spectra) < FEWEST_FOR_MOVEMENT or explained < EXPLAINED:
        return []
    # Low frequencies hardly separate the two: there both stay in the traces.
    surface = covariance / (variance + LEAST_VARIANCE * variance.max())
    place = int(np.argmax(_magnitude(covariance, sweep)))
    moved = (spectra * back).mean(axis=0)
    shown, needed = (_magnitude(one, sweep)[place] for one in (moved, surface))
    if shown < LEAST_SHOWN * needed:
        return []
    alone = (spectra - (mean - surface * mean_moving)) * back
    unmoved_s = np.zeros(len(spectra))
    return [_CommonEchoes(alone, covariance, sweep, path_s, unmoved_s, True, plate)]


def _magnitude(spectra: np.ndarray, sweep: FrequencyGrid) -> np.ndarray:
    """Return the magnitude over the delay."""
    return np.abs(a_scans(spectra, sweep, scipy.fft.next_fast_len(PADDING * sweep.count)))
