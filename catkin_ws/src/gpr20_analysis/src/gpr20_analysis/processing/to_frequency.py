"""The transform from time back to frequency, for A-scans that other programs have made."""

from __future__ import annotations

from typing import List, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import faults, work
from gpr20_analysis.dataset import (
    A_SCAN,
    ATTRIBUTES,
    DELAY,
    FREQUENCY,
    HZ_PER_MHZ,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    require,
    usable,
)
from gpr20_analysis.errors import WrongDatasetError
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
    step_s = float(np.ptp(delay_s)) / max(len(delay_s) - 1, 1)
    if len(delay_s) < 2 or np.ptp(np.diff(delay_s)) > EVEN * step_s:
        raise WrongDatasetError(
            Message("the times of the A-scans are not evenly spaced; two or more are needed"),
            fault=faults.INPUT,
        )
    notes: List[Message] = []
    if not (start_hz or stop_hz or points):
        start_hz, stop_hz, points = _band_of(survey, a_scans.values, step_s)
        notes = [
            Message(
                "the frequencies of the A-scans are not recorded; the band {start_mhz:.4g} to "
                "{stop_mhz:.4g} MHz was taken from the spectra; give --band if it is different",
                start_mhz=start_hz / HZ_PER_MHZ,
                stop_mhz=stop_hz / HZ_PER_MHZ,
            )
        ]
    # Written so that NaN is refused too.
    if not (0.0 < start_hz < stop_hz <= 1.0 / step_s and points >= 2):
        raise WrongDatasetError(
            Message(
                "the band {start_mhz:g} to {stop_mhz:g} MHz with {points} points is not allowed; "
                "it must lie between 0 and {highest_mhz:g} MHz and have 2 points or more",
                start_mhz=start_hz / HZ_PER_MHZ,
                stop_mhz=stop_hz / HZ_PER_MHZ,
                points=points,
                highest_mhz=1.0 / step_s / HZ_PER_MHZ,
            ),
            fault=NOT_ALLOWED,
        )
    step_hz = (stop_hz - start_hz) / (points - 1)
    frequency_hz = start_hz + step_hz * np.arange(points)
    # Traces of others may have many samples, at each of which there is a factor for each frequency.
    needed = BYTES_PER_FACTOR * len(frequency_hz) * len(delay_s)
    work.require_bytes(needed, Message("the transform to frequencies"))
    matrix = phase_advance(frequency_hz, -delay_s)
    # The unweighted transform of these spectra to time gives the A-scans back.
    matrix *= step_s * step_hz * points

    # A real trace has half of its spectrum at negative frequencies.
    halves = 2.0 if not np.any(np.imag(a_scans.values)) else 1.0
    spectra = (a_scans.values @ matrix) * halves
    result = survey.drop_vars([A_SCAN, DELAY])
    result = result.assign_coords({FREQUENCY: (FREQUENCY, frequency_hz, ATTRIBUTES[FREQUENCY])})
    result = result.assign({S21: (S21_DIMS, spectra, ATTRIBUTES[S21])})
    return result.assign_attrs(with_notes(result, notes)) if notes else result


def _band_of(survey: xr.Dataset, a_scans: np.ndarray, step_s: float) -> Tuple[float, float, int]:
    """Return first and last frequency of the A-scans [Hz], and how many their duration resolves."""
    rows = a_scans[usable(survey).transpose(*SAMPLE_DIMS).values]
    level = np.sqrt(np.sum(np.abs(np.fft.fft(rows, axis=-1)) ** 2, axis=0))
    # The upper half are the negative frequencies; those of a complex trace may be weaker.
    positive = level[: len(level) // 2]
    strong = np.flatnonzero((positive >= FAINTEST * positive.max()) & (positive > 0.0))
    if strong.size < 2 or strong[-1] <= max(strong[0], 1):
        raise WrongDatasetError(
            Message(
                "every A-scan is zero or missing, or contains a single frequency, so there is no "
                "spectrum that resolves a delay; see gpr20 info"
            ),
            fault=faults.INPUT,
        )
    first, last = max(int(strong[0]), 1), int(strong[-1])
    step_hz = 1.0 / (len(level) * step_s)
    return first * step_hz, last * step_hz, last - first + 1
