"""The transform from time back to frequency, for A-scans that other programs have made."""

from __future__ import annotations

from typing import List

import numpy as np
import xarray as xr

from gpr20_analysis import faults, work
from gpr20_analysis.dataset import (
    A_SCAN,
    ATTRIBUTES,
    DELAY,
    FREQUENCY,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    require,
    usable,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.sentences import with_notes
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.frequency_to_delay import phase_advance

FAINTEST = 0.05
"""Edge of a band that is not recorded: amplitude relative to the strongest frequency."""
EVEN = 1e-3
BYTES_PER_FACTOR = 48.0


def to_frequency(
    survey: xr.Dataset, start_hz: float = 0.0, stop_hz: float = 0.0, points: int = 0
) -> xr.Dataset:
    """Return spectra at the true frequencies of A-scans over time.

    Neither the window nor the scale of other programs is known: levels are relative.

    Args:
        survey: Dataset with `a_scan`, real or complex.
        start_hz: First frequency [Hz]; 0: where the spectra begin.
        stop_hz: Last frequency [Hz]; 0: where the spectra end.
        points: Number of frequencies; 0: as many as the duration resolves.

    Returns:
        Dataset with `s21` (polarization, y, x, frequency) instead of `a_scan`.

    Raises:
        WrongDatasetError: The data are not A-scans, their times are uneven, or the frequencies
            are not allowed.
        TooLargeError: The factors of all samples and frequencies do not fit into the memory.
    """
    a_scans = require(survey, A_SCAN, (*SAMPLE_DIMS, DELAY))
    delay_s = np.asarray(survey[DELAY].values, dtype=np.float64)
    step_s = _step_s(delay_s)
    notes: List[Message] = []
    if start_hz or stop_hz or points:
        sweep = _given(start_hz, stop_hz, points, step_s)
    else:
        sweep = _found(a_scans, survey, step_s)
        ends = sweep.frequency_hz[[0, -1]]
        notes = [
            Message(
                "the frequencies of the A-scans are not recorded; the band {start_hz:.4g} to "
                "{stop_hz:.4g} Hz was taken from the spectra; give --band if it is different",
                start_hz=ends[0],
                stop_hz=ends[1],
            )
        ]
    frequency_hz = sweep.frequency_hz
    # Traces of others may have many samples, at each of which there is a factor for each frequency.
    needed = BYTES_PER_FACTOR * len(frequency_hz) * len(delay_s)
    work.require_bytes(needed, Message("the transform to frequencies"))
    matrix = phase_advance(frequency_hz, -delay_s)
    # The unweighted transform of these spectra to time gives the A-scans back.
    matrix *= step_s * sweep.step_hz * sweep.count

    # A real trace has half of its spectrum at negative frequencies.
    halves = 2.0 if not np.any(np.imag(a_scans.values)) else 1.0
    spectra = (a_scans.values @ matrix) * halves
    result = survey.drop_vars([A_SCAN, DELAY])
    result = result.assign_coords({FREQUENCY: (FREQUENCY, frequency_hz, ATTRIBUTES[FREQUENCY])})
    result = result.assign({S21: (S21_DIMS, spectra, ATTRIBUTES[S21])})
    return result.assign_attrs(with_notes(result, notes)) if notes else result


def _step_s(delay_s: np.ndarray) -> float:
    step_s = (delay_s[-1] - delay_s[0]) / max(len(delay_s) - 1, 1)
    if len(delay_s) < 2 or np.ptp(np.diff(delay_s)) > EVEN * step_s:
        raise WrongDatasetError(
            Message("the times of the A-scans are not evenly spaced; two or more are needed"),
            fault=faults.INPUT,
        )
    return float(step_s)


def _given(start_hz: float, stop_hz: float, points: int, step_s: float) -> FrequencyGrid:
    # Written so that NaN is refused too.
    if not (0.0 < start_hz < stop_hz <= 1.0 / step_s and points >= 2):
        raise WrongDatasetError(
            Message(
                "the band {start_hz:g} to {stop_hz:g} Hz with {points} points is not allowed; it "
                "must lie between 0 and {highest_hz:g} Hz and have 2 points or more",
                start_hz=start_hz,
                stop_hz=stop_hz,
                points=points,
                highest_hz=1.0 / step_s,
            ),
            fault=NOT_ALLOWED,
        )
    return FrequencyGrid(start_hz, (stop_hz - start_hz) / (points - 1), points)


def _found(a_scans: xr.DataArray, survey: xr.Dataset, step_s: float) -> FrequencyGrid:
    rows = np.asarray(a_scans.values)[usable(survey).transpose(*SAMPLE_DIMS).values]
    count = a_scans.sizes[DELAY]
    level = np.sqrt(np.mean(np.abs(np.fft.fft(rows, axis=-1)) ** 2, axis=0)) if len(rows) else None
    if level is None or not np.any(level):
        raise WrongDatasetError(
            Message("every A-scan is zero or missing, so there is no spectrum; see gpr20 info"),
            fault=faults.INPUT,
        )
    # The upper half are the negative frequencies; those of a complex trace may be weaker.
    positive = level[: count // 2]
    strong = np.flatnonzero(positive >= FAINTEST * positive.max())
    first, last = max(int(strong[0]), 1), int(strong[-1])
    if last <= first:
        raise WrongDatasetError(
            Message("the A-scans contain a single frequency, which resolves no delay"),
            fault=faults.INPUT,
        )
    step_hz = 1.0 / (count * step_s)
    return FrequencyGrid(first * step_hz, step_hz, last - first + 1)
