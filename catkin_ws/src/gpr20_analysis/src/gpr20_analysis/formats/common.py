"""What formats of others have in common: a Dataset from their numbers, and their conventions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, Iterable, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import ExportError, UnreadableFileError
from gpr20_analysis.read.survey_grid import grid_of

HIGHEST_M = 10.0


@dataclass
class Imported:
    """What a format of others holds.

    Attributes:
        values: (polarization, y, x, frequency or delay); NaN where there is no sample. Goes into
            the Dataset, where a sample that is damaged in part becomes NaN throughout.
        polarization_deg: Rotations [deg].
        y_m: Rows [m].
        x_m: Columns [m].
        height_m: (polarization, y, x); NaN where it is unknown [m].
        frequency_hz: Frequencies [Hz]; None if the values are over time.
        delay_s: Times [s]; None if the values are over frequency.
        source: Name of the file or folder.
        simulated: Whether no real ground was measured; None if that is unknown.
        notes: What should be known.
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
    notes: List[str] = field(default_factory=list)


def as_dataset(found: Imported) -> xr.Dataset:
    """Return the Dataset of what was imported, missing samples marked and named.

    What only the robot's own surveys have (names, times, remarks) is empty.

    Raises:
        UnreadableFileError: A height cannot be one.
    """
    wrong = found.height_m[(found.height_m < 0.0) | (found.height_m > HIGHEST_M)]
    if wrong.size:
        raise UnreadableFileError(
            f"{found.source} tells {wrong.size} antenna heights that cannot be, e.g. "
            f"{wrong[0]:g} m; 0..{HIGHEST_M:g} m are allowed, NaN if not measured"
        )
    shape = found.values.shape[:3]
    # A sample without any number is one that is not there; one with some NaN is damaged.
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
        {"format": dataset.FORMAT, "source": found.source, "notes": found.notes},
    )
    if found.simulated is not None:
        data.attrs["simulated"] = int(found.simulated)
    data = dataset.described(data)
    data.attrs["missing"] = dataset.missing_samples(data)
    data.attrs["faults"] = [one for one in data.attrs["missing"] if one.startswith("damaged")]
    return data


def on_grid(
    source: str,
    positions: np.ndarray,
    spectra: Iterable[np.ndarray],
    heights_m: Sequence[float],
    frequency_hz: np.ndarray,
    notes: List[str],
    simulated: Optional[bool] = None,
) -> xr.Dataset:
    """Return the Dataset of samples that tell their places but not the grid.

    Args:
        source: Name of the file or folder.
        positions: Rotation [deg], y and x [mm] of each sample.
        spectra: Their numbers; each is read when it is its turn.
        heights_m: Their antenna heights [m]; NaN where unknown.
        frequency_hz: Frequencies [Hz].
        notes: What should be known.
        simulated: Whether no real ground was measured; None if that is unknown.

    Raises:
        DamagedSurveyError: The places are no grid.
        UnreadableFileError: Two samples have one place.
    """
    notes = list(notes)
    grid = grid_of(positions, notes)
    cells = grid.places(positions)
    if len(set(cells)) < len(cells):
        raise UnreadableFileError(f"{source} holds two samples of the same place and rotation")
    values = np.full((grid.cells, len(frequency_hz)), complex(np.nan, np.nan))
    height_m = np.full(grid.cells, np.nan)
    height_m[cells] = heights_m
    for cell, spectrum in zip(cells, spectra):
        values[cell] = spectrum
    return as_dataset(
        Imported(
            values.reshape(*grid.shape, -1),
            grid.polarization_deg,
            np.array(grid.y_mm) / dataset.MM_PER_M,
            np.array(grid.x_mm) / dataset.MM_PER_M,
            height_m.reshape(grid.shape),
            source,
            frequency_hz=frequency_hz,
            simulated=simulated,
            notes=notes,
        )
    )


def usable_samples(survey: xr.Dataset) -> List[Tuple[Tuple[int, int, int], float, float, float]]:
    """Return place in the arrays, x [mm], y [mm] and rotation [deg] of samples with numbers."""
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


DEGREES: Dict[str, float] = {"X": 0.0, "Y": 90.0}
TOLERANCE_DEG = 1.0  # half a motor step


def letters(survey: xr.Dataset) -> Dict[str, int]:
    """Return the index of the polarization of each letter.

    Raises:
        ExportError: A rotation has no letter.
    """
    found: Dict[str, int] = {}
    for index, rotation_deg in enumerate(survey[dataset.POLARIZATION].values):
        letter = next(
            (one for one, own in DEGREES.items() if abs(rotation_deg - own) <= TOLERANCE_DEG), None
        )
        if letter is None or letter in found:
            raise ExportError(
                f"the antennas' rotations are {survey[dataset.POLARIZATION].values.tolist()} deg; "
                "this format knows 0 (X) and 90 (Y) only: select those two"
            )
        found[letter] = index
    return found


def even_step(values: np.ndarray, name: str, unit: str) -> float:
    """Return the spacing of coordinates that must be evenly spaced; 0 for a single one.

    Raises:
        ExportError: They are not.
    """
    if len(values) < 2:
        return 0.0
    steps = np.diff(values)
    if np.ptp(steps) > 0.01 * abs(steps.mean()):
        raise ExportError(
            f"the spacing of {name} is {steps.min():g} to {steps.max():g} {unit}; this format "
            "holds even spacing only"
        )
    return float((values[-1] - values[0]) / (len(values) - 1))
