"""What the import and export formats share: a Dataset from arrays, and conventions."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any, Iterable, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.facts import GRID, with_facts
from gpr20_analysis.read.survey_grid import SurveyGrid, grid_of
from gpr20_analysis.sentences import with_sentences
from gpr20_common.message import Message

HIGHEST_M = 10.0
ROUNDED = (1.0, 0.051, 0.051)  # [deg], [mm]: SEG-Y holds tenths of a millimetre


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
            fault=faults.INPUT,
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
    facts: Mapping[str, Any] = MappingProxyType({}),
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
        facts: What is known of the survey besides, as `facts_beside` returns it.
        delay_s: Times [s]; None if the values are over frequency.
        times: When each sample was measured, NaT where unknown; None: all are unknown.

    Raises:
        DamagedSurveyError: The positions do not form a grid.
        UnreadableFileError: Two samples have the same position, or all are 0.
    """
    notes = list(notes)
    known = _on_known_grid(positions, facts)
    grid, positions = known or (grid_of(positions, notes), positions)
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
    if not np.nan_to_num(values).any():
        raise UnreadableFileError(
            Message("{source} has no sample other than 0; give measured data", source=source),
            fault=faults.INPUT,
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
    return with_facts(data, facts)


def _on_known_grid(
    positions: np.ndarray, facts: Mapping[str, Any]
) -> Optional[Tuple[SurveyGrid, np.ndarray]]:
    """Return the grid of the facts, and the positions on it; None if there is none or they differ.

    Args:
        positions: (samples, 3), rotation [deg], y and x [mm], rounded as files do.
        facts: What the file beside an export says.
    """
    if not all(name in facts for name in GRID):
        return None
    axes = [np.array(facts[name]) for name in GRID]
    nearest = [
        axis[np.abs(axis - own[:, None]).argmin(axis=1)] for axis, own in zip(axes, positions.T)
    ]
    found = np.stack(nearest, axis=1)
    if np.any(np.abs(found - positions) > ROUNDED):
        return None
    return SurveyGrid(*(tuple(axis.tolist()) for axis in axes)), found
