"""Frequencies and rotations of a survey, parts of them, and A-scans at the delays of an FFT."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
import xarray as xr

from gpr20_analysis import errors
from gpr20_analysis.dataset import (
    FREQUENCY,
    HZ_PER_MHZ,
    POLARIZATION,
    S21,
    S21_DIMS,
    require,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message, numeral
from gpr20_survey.radar import Window

# Relative to the step; recorded frequencies are doubles, an instrument rounds to 1 Hz.
STEP_TOLERANCE = 1e-3


@dataclass(frozen=True)
class FrequencyGrid:
    """A uniform grid of frequencies.

    Attributes:
        start_hz: First frequency [Hz].
        step_hz: Distance between two [Hz].
        count: Number of frequencies.
    """

    start_hz: float
    step_hz: float
    count: int

    @property
    def frequency_hz(self) -> np.ndarray:
        """All frequencies [Hz]."""
        return self.start_hz + self.step_hz * np.arange(self.count)

    @property
    def unambiguous_s(self) -> float:
        """Longest unambiguous delay [s]: 1 / step."""
        return 1.0 / self.step_hz

    @property
    def resolution_s(self) -> float:
        """Reciprocal of the bandwidth [s]."""
        return 1.0 / (self.step_hz * (self.count - 1))

    @classmethod
    def of(cls, survey: xr.Dataset) -> FrequencyGrid:
        """Return the sweep of a survey.

        Raises:
            WrongDatasetError: It has fewer than two frequencies, or uneven spacing.
        """
        require(survey, S21, S21_DIMS)
        frequency_hz = np.asarray(survey.coords[FREQUENCY].values, dtype=np.float64)
        count = frequency_hz.size
        step_hz = float(frequency_hz[-1] - frequency_hz[0]) / (count - 1) if count > 1 else 0.0
        off_hz = np.abs(frequency_hz - frequency_hz[:1] - step_hz * np.arange(count)).max(initial=0)
        # Written so that NaN is refused too.
        if not (step_hz > 0.0 and off_hz <= STEP_TOLERANCE * step_hz):
            raise WrongDatasetError(
                Message(
                    "the {count} frequencies are not evenly spaced and ascending: they differ by "
                    "up to {off_hz:g} Hz at a step of {step_hz:g} Hz; measure with a linear sweep "
                    "of two or more, or resample",
                    count=count,
                    off_hz=off_hz,
                    step_hz=step_hz,
                ),
                fault=errors.INPUT,
            )
        return cls(float(frequency_hz[0]), step_hz, count)


def even_delays_s(sweep: FrequencyGrid, count: int) -> np.ndarray:
    """Return delays over the unambiguous range, from 0 [s]."""
    return np.arange(count) * (sweep.unambiguous_s / count)


def a_scans(
    spectra: np.ndarray, sweep: FrequencyGrid, count: int, window: Window = Window.HANN
) -> np.ndarray:
    """Return A-scans (..., delay) at even delays: spectra @ `delay_kernel` by an FFT, far faster.

    Args:
        spectra: Spectra (..., frequency).
        sweep: Their frequencies.
        count: Number of delays, at least that of the frequencies.
        window: Weights over the band.
    """
    return summed(spectra * window.shares(sweep.count), sweep, count)


def summed(weighted: np.ndarray, sweep: FrequencyGrid, count: int) -> np.ndarray:
    """Return the A-scans of spectra that were weighted."""
    samples: np.ndarray = scipy.fft.ifft(weighted, count, axis=-1, workers=2)
    # ifft divides by the count; the true frequency of the first value is put back as a phase.
    turns = sweep.start_hz * even_delays_s(sweep, count)
    samples *= (count * np.exp(2j * np.pi * turns)).astype(samples.dtype)
    return samples


def steps_to_top(level: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return where a parabola through the values beside a maximum has its top, in steps from it.

    Args:
        level: Values (row, step).
        at: Step of each row's maximum, not the first nor the last.
    """
    rows = np.arange(len(level))
    # In double precision the smallest curvature is not 0: the top of a plateau is its middle.
    before, here, after = (level[rows, at + one].astype(np.float64) for one in (-1, 0, 1))
    steps: np.ndarray = 0.5 * (before - after) / np.minimum(before - 2.0 * here + after, -1e-300)
    return steps


def select_band(survey: xr.Dataset, start_hz: float, stop_hz: float) -> xr.Dataset:
    """Select the frequencies from start to stop, both included [Hz].

    Raises:
        WrongDatasetError: Fewer than two frequencies would be left.
    """
    frequency_hz = survey[FREQUENCY].values
    kept = (frequency_hz >= start_hz) & (frequency_hz <= stop_hz)
    if np.count_nonzero(kept) < 2:
        raise WrongDatasetError(
            Message(
                "the band {start_mhz:g} to {stop_mhz:g} MHz contains {count} frequencies of the "
                "sweep {first_mhz:g} to {last_mhz:g} MHz; two or more are needed",
                start_mhz=start_hz / HZ_PER_MHZ,
                stop_mhz=stop_hz / HZ_PER_MHZ,
                count=np.count_nonzero(kept),
                first_mhz=frequency_hz[0] / HZ_PER_MHZ,
                last_mhz=frequency_hz[-1] / HZ_PER_MHZ,
            ),
            fault=NOT_ALLOWED,
        )
    return survey.isel({FREQUENCY: kept})


ROTATION_TOLERANCE_DEG = 0.5
# Of the sweep's step.
FREQUENCY_TOLERANCE = 1e-3


def select_polarization(survey: xr.Dataset, rotation_deg: float) -> xr.Dataset:
    """Select one polarization.

    Raises:
        WrongDatasetError: It was not measured.
    """
    turns = survey[POLARIZATION].values
    near = np.flatnonzero(np.abs(turns - rotation_deg) <= ROTATION_TOLERANCE_DEG)
    if near.size == 0:
        raise WrongDatasetError(
            Message(
                "rotation {rotation_deg:g} deg was not measured; the data have {rotations} deg",
                rotation_deg=rotation_deg,
                rotations=tuple(map(numeral, turns)),
            ),
            fault=NOT_ALLOWED,
        )
    return survey.isel({POLARIZATION: near[:1]})


def matched(reference: xr.Dataset, survey: xr.Dataset) -> xr.Dataset:
    """Return those rotations of a reference that a survey has, with the survey's coordinates.

    Raises:
        WrongDatasetError: It has another sweep, or lacks a rotation.
    """
    own_hz, other_hz = (one[FREQUENCY].values for one in (survey, reference))
    off_deg = np.abs(survey[POLARIZATION].values[:, None] - reference[POLARIZATION].values)
    most_hz = FREQUENCY_TOLERANCE * float(np.ptp(own_hz)) / max(len(own_hz) - 1, 1)
    # Written so that NaN is refused too.
    if not (
        own_hz.shape == other_hz.shape
        and np.all(np.abs(own_hz - other_hz) <= most_hz)
        and np.all(off_deg.min(axis=1) <= ROTATION_TOLERANCE_DEG)
    ):
        raise WrongDatasetError(
            Message(
                "the reference was measured at {reference}, the survey at {survey}; measure both "
                "with the same sweep and rotations",
                reference=_settings(reference),
                survey=_settings(survey),
            ),
            fault=errors.INPUT,
        )
    found = reference.isel({POLARIZATION: off_deg.argmin(axis=1)})
    return found.assign_coords({name: survey[name] for name in (POLARIZATION, FREQUENCY)})


def _settings(data: xr.Dataset) -> Message:
    frequency_hz = data[FREQUENCY].values
    return Message(
        "{start_mhz:g} to {stop_mhz:g} MHz, {count} points, {rotations} deg",
        start_mhz=frequency_hz[0] / HZ_PER_MHZ,
        stop_mhz=frequency_hz[-1] / HZ_PER_MHZ,
        count=len(frequency_hz),
        rotations=tuple(map(numeral, data[POLARIZATION].values)),
    )
