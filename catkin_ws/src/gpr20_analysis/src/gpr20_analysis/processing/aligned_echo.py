"""The echo of the surface in the traces of one polarization, aligned by their heights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional

import numpy as np
import scipy.fft

from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans
from gpr20_common.message import Message
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S, one_way_path_m
from gpr20_survey.radar.frequency_to_delay import Window, phase_advance

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
class _Aligned:
    """Traces whose surface echoes lie at one delay, that of cables and antennas.

    Attributes:
        spectra: Complex spectra (trace, frequency).
        common: Spectrum of what they have in common.
        unmoved_s: Delay by which each was not moved although its height says so [s].
    """

    spectra: np.ndarray
    common: np.ndarray
    unmoved_s: np.ndarray


@dataclass(frozen=True)
class _Echoes:
    """The maxima of the common trace, by their delay.

    Attributes:
        delay_s: Delay beyond the path by the height [s].
        level: Magnitude.
        coherence: Magnitude over the root mean square of all traces there.
        floor: Median magnitude of the trace.
    """

    delay_s: np.ndarray
    level: np.ndarray
    coherence: np.ndarray
    floor: float

    @property
    def strong(self) -> np.ndarray:
        """Places of the strong echoes that all traces have in common; else of the strongest."""
        common = np.where(self.coherence >= COMMON, self.level, 0.0)
        if not np.any(common):
            common = np.where(self.level == self.level.max(), self.level, 0.0)
        return np.flatnonzero(common >= max(LAST_STRONG * common.max(), 1e-300))


class SurfaceEcho:
    """The echo of the surface in the traces of one polarization.

    Attributes:
        delays_s: Delay of the echo of each trace beyond its path; NaN if it is not near the
            common one [s].
        interference_s: How much other echoes may move all of them [s].
        by_movement: Whether coupling and surface were separated by the differing heights.
    """

    def __init__(
        self, spectra: np.ndarray, sweep: FrequencyGrid, path_m: np.ndarray, plate: bool
    ) -> None:
        """Find the echo.

        Args:
            spectra: Complex spectra (trace, frequency).
            sweep: Their frequencies.
            path_m: Path over the surface from one antenna to the other, for each trace [m].
            plate: Whether the surface is a metal plate, with the strongest echo.

        Raises:
            WrongDatasetError: It is not clear; the message says why.
        """
        self._sweep = sweep
        self._path_s = path_m / SPEED_OF_LIGHT_M_S
        self._check_input(spectra)
        moving = self._moving(spectra)
        self.by_movement = moving is not None
        tried = [moving] if moving is not None else self._not_moving(spectra)
        echoes = [self._echoes(one) for one in tried]
        places = [self._surface(one, plate) for one in echoes]
        best = int(np.argmax([one.level[place] for one, place in zip(echoes, places)]))
        chosen, found, place = tried[best], echoes[best], places[best]
        self._check(found, place, plate, chosen.unmoved_s)
        delay_s = float(found.delay_s[place])
        self.delays_s = self._near(chosen.spectra, delay_s) - chosen.unmoved_s
        self.interference_s = (
            SMALLEST_S
            + self._interference_s(found, place)
            + self._window_spread_s(chosen.common, delay_s)
        )

    @property
    def _resolution_s(self) -> float:
        return 1.0 / (self._sweep.step_hz * (self._sweep.count - 1))

    def _check_input(self, spectra: np.ndarray) -> None:
        if not np.any(spectra):
            raise WrongDatasetError(Message("no trace has data and a height"))
        if self._resolution_s > 0.5 * float(np.median(self._path_s)):
            raise WrongDatasetError(
                Message(
                    "a band of {band_hz:g} Hz does not separate it from the coupling of the "
                    "antennas; use a wider band",
                    band_hz=1.0 / self._resolution_s,
                )
            )

    def _moving(self, spectra: np.ndarray) -> Optional[_Aligned]:
        """Return what moves with the heights; None if that does not explain what differs.

        Each trace is modelled as one spectrum that all have in common, the coupling, and one that
        moves with the height, the surface. By least squares, the second is the covariance of
        traces and movement divided by the variance of the movement.
        """
        back = self._turned(self._path_s)
        moving = back.conj() * (np.mean(self._path_s) / self._path_s[:, None])
        mean, mean_moving = spectra.mean(axis=0), moving.mean(axis=0)
        changes, movement = spectra - mean, moving - mean_moving
        covariance = np.mean(changes * movement.conj(), axis=0)
        variance = np.mean(np.abs(movement) ** 2, axis=0)
        left = changes - covariance / np.maximum(variance, 1e-12) * movement
        explained = 1.0 - np.sum(np.abs(left) ** 2) / max(np.sum(np.abs(changes) ** 2), 1e-300)
        if len(spectra) < FEWEST_FOR_MOVEMENT or explained < EXPLAINED:
            return None
        # Low frequencies hardly separate the two: there both stay in the traces.
        surface = covariance / (variance + LEAST_VARIANCE * variance.max())
        moved = spectra * back
        place = int(np.argmax(self._a_scan(covariance)))
        shown, needed = (self._a_scan(one)[place] for one in (moved.mean(axis=0), surface))
        if shown < LEAST_SHOWN * needed:
            return None
        alone = spectra - (mean - surface * mean_moving)
        return _Aligned(alone * back, covariance, np.zeros(len(spectra)))

    def _not_moving(self, spectra: np.ndarray) -> List[_Aligned]:
        """Return the traces moved by their heights, and all moved by the median height.

        Recorded heights that differ only by the noise of their sensor would blur the echo.
        """
        middle_s = np.full(len(self._path_s), np.median(self._path_s))
        found = []
        for delay_s in (self._path_s, middle_s):
            moved = spectra * self._turned(delay_s)
            found.append(_Aligned(moved, moved.mean(axis=0), self._path_s - delay_s))
        return found

    def _turned(self, delay_s: np.ndarray) -> np.ndarray:
        return phase_advance(self._sweep.frequency_hz, delay_s)

    def _a_scan(self, spectra: np.ndarray) -> np.ndarray:
        """Return the magnitude over the delay."""
        count = scipy.fft.next_fast_len(PADDING * self._sweep.count)
        return np.abs(a_scans(spectra, self._sweep, count))

    def _echoes(self, traces: _Aligned) -> _Echoes:
        magnitude = self._a_scan(traces.common)
        singles = np.sqrt(np.mean(self._a_scan(traces.spectra) ** 2, axis=0))
        if self.by_movement:
            coherence = self._a_scan(traces.spectra.mean(axis=0)) / np.maximum(singles, 1e-300)
        else:
            coherence = magnitude / np.maximum(singles, 1e-300)
        is_top = (magnitude >= np.roll(magnitude, 1)) & (magnitude > np.roll(magnitude, -1))
        places = np.flatnonzero(is_top)
        if not places.size:
            places = np.array([np.argmax(magnitude)])
        # Delays repeat: what seems late by almost the whole period is early.
        period_s = self._sweep.unambiguous_s
        earliest_s = -float(np.median(self._path_s)) - self._resolution_s
        delay_s = places * (period_s / len(magnitude))
        delay_s = (delay_s - earliest_s) % period_s + earliest_s
        order = np.argsort(delay_s)
        places = places[order]
        return _Echoes(
            delay_s[order], magnitude[places], coherence[places], float(np.median(magnitude))
        )

    def _surface(self, echoes: _Echoes, plate: bool) -> int:
        """Return which of the echoes is that of the surface."""
        if self.by_movement or plate:
            return int(np.argmax(echoes.level))
        return int(echoes.strong[-1])

    def _check(self, echoes: _Echoes, place: int, plate: bool, unmoved_s: np.ndarray) -> None:
        if not echoes.level[place] > CLEAR * echoes.floor:
            raise WrongDatasetError(
                Message("no echo rises above the noise in the mean of all traces")
            )
        if not echoes.coherence[place] >= (COMMON_MOVING if self.by_movement else COMMON):
            raise WrongDatasetError(
                Message(
                    "the traces have no echo in common; fit the delay to the survey as measured, "
                    "before its background is removed"
                )
            )
        second = np.max(np.delete(echoes.level, place), initial=0.0)
        if plate and not self.by_movement and second > SECOND_OF_PLATE * echoes.level[place]:
            raise WrongDatasetError(
                Message(
                    "the echo of the plate is not stronger than the coupling of the antennas; "
                    "measure the plate at a smaller height"
                )
            )
        earliest_s = EARLIEST_MOVING_S if self.by_movement else EARLIEST_S
        if not earliest_s <= echoes.delay_s[place] <= LATEST_S:
            raise WrongDatasetError(
                Message(
                    "the last strong echo of all traces is {delay_ns:.2f} ns later than the "
                    "heights say; {earliest_ns:g} to {latest_ns:g} ns are allowed",
                    delay_ns=echoes.delay_s[place] * 1e9,
                    earliest_ns=earliest_s * 1e9,
                    latest_ns=LATEST_S * 1e9,
                )
            )
        if not self.by_movement and not plate:
            self._check_rigid(unmoved_s)
            self._check_alone(echoes)

    def _check_rigid(self, unmoved_s: np.ndarray) -> None:
        spread_m = one_way_path_m(float(np.std(unmoved_s)))
        if spread_m > SENSOR_NOISE_M:
            raise WrongDatasetError(
                Message(
                    "the heights differ by {spread_mm:.0f} mm (standard deviation), but the echo "
                    "that all traces have in common does not move with them",
                    spread_mm=1e3 * spread_m,
                )
            )

    def _check_alone(self, echoes: _Echoes) -> None:
        strong = echoes.strong
        later = echoes.delay_s > echoes.delay_s[strong[-1]] + FROM_SIDELOBES * self._resolution_s
        weak = (echoes.level > WEAK_SURFACE * echoes.level.max()) & (echoes.coherence >= COMMON)
        others = int(np.count_nonzero(later & weak)) if len(strong) == 1 else 0
        count = len(strong) + others
        if count > MOST_STRONG or others:
            raise WrongDatasetError(
                Message(
                    "all traces have {count} strong echoes in common, so it is not known which is "
                    "the surface; measure at different heights, or over a metal plate",
                    count=count,
                )
            )

    def _interference_s(self, echoes: _Echoes, place: int) -> float:
        """Return how much the other echoes can move one, by their share at its delay [s]."""
        weights = Window.HANN.weights(self._sweep.count)
        away_s = np.delete(echoes.delay_s, place) - echoes.delay_s[place]
        turns = np.exp(2j * np.pi * np.outer(away_s, self._sweep.frequency_hz))
        share = np.abs(turns @ weights) / weights.sum()
        others = np.delete(echoes.level, place) / echoes.level[place]
        # What is below the noise is not an echo; the spread of the traces contains it.
        others = np.where(np.delete(echoes.level, place) > CLEAR * echoes.floor, others, 0.0)
        return float(PULL * self._resolution_s * np.sum(share * others))

    def _window_spread_s(self, common: np.ndarray, delay_s: float) -> float:
        """Return by how much the delay depends on the window, as merged echoes make it [s]."""
        delays_s = np.array([self._near(common[None], delay_s, one)[0] for one in Window])
        found_s = delays_s[np.isfinite(delays_s)]
        return float(np.ptp(found_s)) if found_s.size else 0.0

    def _near(
        self, spectra: np.ndarray, delay_s: float, window: Window = Window.HANN
    ) -> np.ndarray:
        """Return the delay of the strongest value near a delay; NaN if it is at the edge [s]."""
        steps = STEPS_NEAR
        near_s = delay_s + self._resolution_s * np.linspace(-1.0, 1.0, 2 * steps + 1)
        weights = window.weights(self._sweep.count)
        turned = np.exp(2j * np.pi * np.outer(self._sweep.frequency_hz, near_s))
        level = np.abs(spectra @ (turned * weights[:, None]))
        top = np.argmax(level, axis=1)
        at = np.clip(top, 1, 2 * steps - 1)
        rows = np.arange(len(level))
        before, here, after = (level[rows, at + one] for one in (-1, 0, 1))
        bend = np.minimum(before - 2.0 * here + after, -1e-300)
        found_s: np.ndarray = near_s[at] + 0.5 * (before - after) / bend * (near_s[1] - near_s[0])
        return np.where(top == at, found_s, np.nan)
