"""A Dataset from numbers that came from a format of others."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import List, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.mid import dataset
from gpr20_analysis.mid.dataset import Quality

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
    for variable in data.variables:
        data[variable].attrs.update(dataset.ATTRIBUTES.get(str(variable), {}))
    data[dataset.QUALITY].attrs.update(dataset.QUALITY_ATTRIBUTES)
    data.attrs["missing"] = dataset.missing_samples(data)
    data.attrs["faults"] = [one for one in data.attrs["missing"] if one.startswith("damaged")]
    return data
