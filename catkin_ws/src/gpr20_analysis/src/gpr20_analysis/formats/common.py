"""What imports share: a Dataset from arrays, and spectra from A-scans over time."""

from __future__ import annotations

from typing import Iterable, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, errors, work
from gpr20_analysis.dataset import (
    A_SCAN,
    ATTRIBUTES,
    DELAY,
    FREQUENCY,
    HZ_PER_MHZ,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    Quality,
    require,
    usable,
)
from gpr20_analysis.errors import UnreadableFileError, WrongDatasetError
from gpr20_analysis.read.traces import grid_of
from gpr20_analysis.sentences import with_notes, with_sentences
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import phase_advance

HIGHEST_M = 10.0


def as_dataset(
    values: np.ndarray,
    polarization_deg: Sequence[float],
    y_m: np.ndarray,
    x_m: np.ndarray,
    height_m: np.ndarray,
    source: str,
    frequency_hz: Optional[np.ndarray] = None,
    delay_s: Optional[np.ndarray] = None,
    simulated: Optional[bool] = None,
    notes: Sequence[Message] = (),
) -> xr.Dataset:
    """Return the Dataset of imported data; missing samples are marked and named.

    Names, times and remarks, which only the robot's own surveys have, are empty.

    Args:
        values: (polarization, y, x, frequency or delay); NaN where there is no sample. Becomes
            part of the Dataset, where all values of a partly damaged sample become NaN.
        polarization_deg: Rotations [deg].
        y_m: Rows [m].
        x_m: Columns [m].
        height_m: Antenna heights (polarization, y, x); NaN where unknown [m].
        source: Name of the file or folder.
        frequency_hz: Frequencies [Hz]; None if the values are over time.
        delay_s: Times [s]; None if the values are over frequency.
        simulated: Whether the data are simulated; None if unknown.
        notes: What a user should know.

    Raises:
        UnreadableFileError: A height is out of range.
    """
    wrong = height_m[(height_m < 0.0) | (height_m > HIGHEST_M)]
    if wrong.size:
        raise UnreadableFileError(
            Message(
                "{source} has {count} antenna heights out of range, e.g. {height_m:g} m; use 0 to "
                "{highest_m:g} m, or NaN if not measured",
                source=source,
                count=wrong.size,
                height_m=wrong[0],
                highest_m=HIGHEST_M,
            ),
            fault=errors.INPUT,
        )
    shape = values.shape[:3]
    # A sample of only NaN is missing; one with some NaN is damaged.
    bad = ~np.isfinite(values)
    missing, damaged = bad.all(axis=-1), bad.any(axis=-1)
    quality = np.zeros(shape, np.uint8)
    quality[damaged] = int(Quality.DAMAGED)
    quality[missing] = int(Quality.MISSING)
    quality[~damaged & ~np.isfinite(height_m)] |= int(Quality.NO_HEIGHT)
    values[damaged] = np.nan
    name, last, axis = (dataset.S21, dataset.FREQUENCY, frequency_hz)
    if axis is None:
        name, last, axis = (dataset.A_SCAN, dataset.DELAY, delay_s)
    sample = dataset.SAMPLE_DIMS
    data = xr.Dataset(
        {
            name: ((*sample, last), values),
            dataset.HEIGHT: (sample, height_m),
            dataset.TIMESTAMP: (sample, np.full(shape, "NaT", "datetime64[ns]")),
            dataset.QUALITY: (sample, quality),
            "remarks": (sample, np.full(shape, "", "<U1")),
            "sample_id": (sample, np.full(shape, "", "<U1")),
            "index": (sample, np.where(missing, -1, np.arange(quality.size).reshape(shape))),
        },
        {
            dataset.POLARIZATION: np.asarray(polarization_deg, np.float64),
            dataset.Y: y_m,
            dataset.X: x_m,
            last: axis,
        },
        {"format": dataset.FORMAT, "source": source},
    )
    if simulated is not None:
        data.attrs["simulated"] = int(simulated)
    data = dataset.described(data)
    places = dataset.positions_of(data, damaged & ~missing)
    lists = {
        "missing": dataset.missing_samples(data),
        "faults": [Message("damaged: {position}", position=one) for one in places],
    }
    return data.assign_attrs(with_sentences(data.attrs, **lists, notes=notes))


def on_grid(
    source: str,
    positions: np.ndarray,
    spectra: Iterable[np.ndarray],
    heights_m: Sequence[float],
    frequency_hz: Optional[np.ndarray],
    notes: List[Message],
    simulated: Optional[bool] = None,
    delay_s: Optional[np.ndarray] = None,
    times: Optional[Sequence[np.datetime64]] = None,
) -> xr.Dataset:
    """Return the Dataset of samples whose positions are known but not their grid.

    Args:
        source: Name of the file or folder.
        positions: Rotation [deg], y and x [mm] of each sample.
        spectra: Their spectra, read one after another.
        heights_m: Their antenna heights [m]; NaN where unknown.
        frequency_hz: Frequencies [Hz]; None if the values are over time.
        notes: What a user should know.
        simulated: Whether the data are simulated; None if unknown.
        delay_s: Times [s]; None if the values are over frequency.
        times: When each sample was measured, NaT where unknown; None: all are unknown.

    Raises:
        DamagedSurveyError: The positions do not form a grid.
        UnreadableFileError: Two samples have the same position, or all are 0.
    """
    notes = list(notes)
    grid = grid_of(positions, notes)
    cells = grid.places(positions)
    if len(set(cells)) < len(cells):
        raise UnreadableFileError(
            Message(
                "{source} has two samples at the same position and rotation; give data with one",
                source=source,
            ),
            fault=errors.INPUT,
        )
    axis = delay_s if frequency_hz is None else frequency_hz
    if axis is None:
        raise ValueError("neither frequencies nor times")
    values = np.full((grid.cells, len(axis)), complex(np.nan, np.nan))
    height_m = np.full(grid.cells, np.nan)
    height_m[cells] = heights_m
    for cell, spectrum in zip(cells, spectra):
        values[cell] = spectrum
    if not np.nan_to_num(values).any():
        raise UnreadableFileError(
            Message("{source} has no sample other than 0; give measured data", source=source),
            fault=errors.INPUT,
        )
    data = as_dataset(
        values.reshape(*grid.shape, -1),
        grid.polarization_deg,
        np.array(grid.y_mm) / dataset.MM_PER_M,
        np.array(grid.x_mm) / dataset.MM_PER_M,
        height_m.reshape(grid.shape),
        source,
        frequency_hz,
        delay_s,
        simulated,
        notes,
    )
    if times is not None:
        data[dataset.TIMESTAMP].values.reshape(-1)[cells] = times
    return data


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
            fault=errors.INPUT,
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
            fault=errors.INPUT,
        )
    first, last = max(int(strong[0]), 1), int(strong[-1])
    step_hz = 1.0 / (len(level) * step_s)
    return first * step_hz, last * step_hz, last - first + 1
