"""What the import and export formats share: a Dataset from arrays, and conventions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import ExportError, UnreadableFileError
from gpr20_analysis.formats.facts import Facts, snapped
from gpr20_analysis.read.survey_grid import grid_of
from gpr20_analysis.sentences import with_decisions, with_sentences
from gpr20_common.message import Message

HIGHEST_M = 10.0


@dataclass
class Imported:
    """The content of an imported file.

    Attributes:
        values: (polarization, y, x, frequency or delay); NaN where there is no sample. Becomes
            part of the Dataset, where all values of a partly damaged sample become NaN.
        polarization_deg: Rotations [deg].
        y_m: Rows [m].
        x_m: Columns [m].
        height_m: Antenna heights (polarization, y, x); NaN where unknown [m].
        frequency_hz: Frequencies [Hz]; None if the values are over time.
        delay_s: Times [s]; None if the values are over frequency.
        source: Name of the file or folder.
        simulated: Whether the data are simulated; None if unknown.
        notes: What a user should know.
        decisions: What was decided where the source says nothing.
    """

    values: np.ndarray
    polarization_deg: Sequence[float]
    y_m: np.ndarray
    x_m: np.ndarray
    height_m: np.ndarray
    source: str
    frequency_hz: Optional[np.ndarray] = None
    delay_s: Optional[np.ndarray] = None
    simulated: Optional[bool] = None
    notes: List[Message] = field(default_factory=list)
    decisions: Sequence[Message] = ()


def as_dataset(found: Imported) -> xr.Dataset:
    """Return the Dataset of imported data; missing samples are marked and named.

    Names, times and remarks, which only the robot's own surveys have, are empty.

    Raises:
        UnreadableFileError: A height is out of range.
    """
    wrong = found.height_m[(found.height_m < 0.0) | (found.height_m > HIGHEST_M)]
    if wrong.size:
        raise UnreadableFileError(
            Message(
                "{source} has {count} antenna heights out of range, e.g. {height_m:g} m; use 0 to "
                "{highest_m:g} m, or NaN if not measured",
                source=found.source,
                count=wrong.size,
                height_m=wrong[0],
                highest_m=HIGHEST_M,
            ),
            fault=faults.INPUT,
        )
    shape = found.values.shape[:3]
    # A sample of only NaN is missing; one with some NaN is damaged.
    bad = ~np.isfinite(found.values)
    missing, damaged = bad.all(axis=-1), bad.any(axis=-1)
    quality = np.zeros(shape, np.uint8)
    quality[damaged] = int(Quality.DAMAGED)
    quality[missing] = int(Quality.MISSING)
    quality[~damaged & ~np.isfinite(found.height_m)] |= int(Quality.NO_HEIGHT)
    values = found.values
    values[damaged] = np.nan
    name, last, axis = (dataset.S21, dataset.FREQUENCY, found.frequency_hz)
    if axis is None:
        name, last, axis = (dataset.A_SCAN, dataset.DELAY, found.delay_s)
    sample = dataset.SAMPLE_DIMS
    data = xr.Dataset(
        {
            name: ((*sample, last), values),
            dataset.HEIGHT: (sample, found.height_m),
            dataset.TIMESTAMP: (sample, np.full(shape, "NaT", "datetime64[ns]")),
            dataset.QUALITY: (sample, quality),
            "remarks": (sample, np.full(shape, "", "<U1")),
            "sample_id": (sample, np.full(shape, "", "<U1")),
            "index": (sample, np.where(missing, -1, np.arange(quality.size).reshape(shape))),
        },
        {
            dataset.POLARIZATION: np.asarray(found.polarization_deg, np.float64),
            dataset.Y: found.y_m,
            dataset.X: found.x_m,
            last: axis,
        },
        {"format": dataset.FORMAT, "source": found.source},
    )
    if found.simulated is not None:
        data.attrs["simulated"] = int(found.simulated)
    data = dataset.described(data)
    places = dataset.positions_of(data, damaged & ~missing)
    lists = {
        "missing": dataset.missing_samples(data),
        "faults": [Message("damaged: {position}", position=one) for one in places],
    }
    data = data.assign_attrs(with_sentences(data.attrs, **lists, notes=found.notes))
    return with_decisions(data, *found.decisions) if found.decisions else data


def on_grid(
    source: str,
    positions: np.ndarray,
    spectra: Iterable[np.ndarray],
    heights_m: Sequence[float],
    frequency_hz: Optional[np.ndarray],
    notes: List[Message],
    simulated: Optional[bool] = None,
    facts: Optional[Facts] = None,
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
        facts: What is known of the survey besides.
        delay_s: Times [s]; None if the values are over frequency.
        times: When each sample was measured, NaT where unknown; None: all are unknown.

    Raises:
        DamagedSurveyError: The positions do not form a grid.
        UnreadableFileError: Two samples have the same position.
    """
    notes = list(notes)
    known = None if facts is None else snapped(positions, facts.grid)
    if facts is None or facts.grid is None or known is None:
        grid = grid_of(positions, notes)
    else:
        grid, positions = facts.grid, known
    cells = grid.places(positions)
    if len(set(cells)) < len(cells):
        raise UnreadableFileError(
            Message(
                "{source} has two samples at the same position and rotation; give data with one",
                source=source,
            ),
            fault=faults.INPUT,
        )
    axis = delay_s if frequency_hz is None else frequency_hz
    if axis is None:
        raise ValueError("neither frequencies nor times")
    values = np.full((grid.cells, len(axis)), complex(np.nan, np.nan))
    height_m = np.full(grid.cells, np.nan)
    height_m[cells] = heights_m
    for cell, spectrum in zip(cells, spectra):
        values[cell] = spectrum
    data = as_dataset(
        Imported(
            values.reshape(*grid.shape, -1),
            grid.polarization_deg,
            np.array(grid.y_mm) / dataset.MM_PER_M,
            np.array(grid.x_mm) / dataset.MM_PER_M,
            height_m.reshape(grid.shape),
            source,
            frequency_hz=frequency_hz,
            delay_s=delay_s,
            simulated=simulated,
            notes=notes,
        )
    )
    if times is not None:
        data[dataset.TIMESTAMP].values.reshape(-1)[cells] = times
    return data if facts is None else facts.restored(data)


def usable_samples(survey: xr.Dataset) -> List[Tuple[Tuple[int, int, int], float, float, float]]:
    """Return array index, x [mm], y [mm] and rotation [deg] of each sample with data."""
    usable = dataset.usable(survey).transpose(*dataset.SAMPLE_DIMS).values
    turns_deg, y_m, x_m = (survey[axis].values for axis in dataset.SAMPLE_DIMS)
    return [
        (
            (int(turn), int(row), int(column)),
            float(x_m[column]) * dataset.MM_PER_M,
            float(y_m[row]) * dataset.MM_PER_M,
            float(turns_deg[turn]),
        )
        for turn, row, column in np.argwhere(usable)
    ]


def even_step(values: np.ndarray, name: Union[str, Message], unit: str) -> float:
    """Return the spacing of evenly spaced coordinates; 0 for a single one.

    Raises:
        ExportError: The spacing is uneven.
    """
    if len(values) < 2:
        return 0.0
    steps = np.diff(values)
    if np.ptp(steps) > 0.01 * abs(steps.mean()):
        raise ExportError(
            Message(
                "the spacing of {axis} is uneven, {smallest:g} to {largest:g} {unit}; choose a "
                "format that supports that",
                axis=name,
                smallest=steps.min(),
                largest=steps.max(),
                unit=unit,
            ),
            fault=faults.INPUT,
        )
    return float((values[-1] - values[0]) / (len(values) - 1))
