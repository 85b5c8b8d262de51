"""Checks a Dataset that comes from a file: what is damaged is refused or marked, never used."""

from __future__ import annotations

from typing import Dict, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import DamagedSurveyError, UnreadableFileError

VALUES: Dict[str, Tuple[str, ...]] = {
    dataset.S21: dataset.S21_DIMS,
    dataset.A_SCAN: (*dataset.SAMPLE_DIMS, dataset.DELAY),
    dataset.IMAGE: (dataset.POLARIZATION, dataset.DEPTH, dataset.Y, dataset.X),
}
"""What a Dataset may hold, and over which dimensions."""
ASCENDING = (dataset.Y, dataset.X, dataset.FREQUENCY, dataset.DELAY, dataset.DEPTH)
ACCEPT = "--accept-damaged leaves them out, marked"


def checked(data: xr.Dataset, name: str, accept_damaged: bool = False) -> xr.Dataset:
    """Return a Dataset as `gpr20_analysis.dataset` describes it, or refuse it.

    Attribute `missing` names every sample without numbers, whatever the file said.

    Args:
        data: What a file holds, in memory or lazy.
        name: The file, for messages.
        accept_damaged: Mark usable samples that hold NaN as damaged instead of refusing.

    Raises:
        UnreadableFileError: It is no survey, no A-scans and no image.
        DamagedSurveyError: Numbers are NaN or infinite where they should not be.
    """
    held = [one for one in VALUES if one in data]
    if not held:
        names = ", ".join(sorted(map(str, data.data_vars))) or "nothing"
        raise UnreadableFileError(
            f"{name} was not written by gpr20: it holds {names}, but none of {', '.join(VALUES)}"
        )
    for one in held:
        dims = tuple(data[one].dims)
        if set(dims) != set(VALUES[one]) or 0 in data[one].shape:
            raise UnreadableFileError(
                f"{name}: '{one}' has the dimensions {dict(data[one].sizes)}; it must have some of "
                f"each of {', '.join(VALUES[one])}"
            )
        _check_axes(data, one, name)
    if dataset.IMAGE in held and not bool(np.isfinite(data[dataset.IMAGE]).all()):
        raise DamagedSurveyError(f"{name} is damaged: its image holds values that are no numbers")
    sampled = [one for one in held if one != dataset.IMAGE]
    for one in sampled:
        data = _check_samples(data, one, name, accept_damaged)
    return data


def _check_axes(data: xr.Dataset, one: str, name: str) -> None:
    for axis in VALUES[one]:
        values = data[axis].values if axis in data.coords else None
        if values is None or values.dtype.kind not in "fiu":
            raise UnreadableFileError(f"{name} does not tell the values of {axis}")
        if axis in ASCENDING and not (
            np.isfinite(values).all() and (np.diff(values.astype(np.float64)) > 0).all()
        ):
            raise DamagedSurveyError(f"{name} is damaged: its values of {axis} do not ascend")


def _check_samples(data: xr.Dataset, one: str, name: str, accept_damaged: bool) -> xr.Dataset:
    for variable in (dataset.QUALITY, dataset.HEIGHT):
        if variable not in data or set(data[variable].dims) != set(dataset.SAMPLE_DIMS):
            raise UnreadableFileError(f"{name} holds no '{variable}' for each sample of '{one}'")
    quality = data[dataset.QUALITY].transpose(*dataset.SAMPLE_DIMS)
    if quality.dtype.kind not in "ui":
        raise UnreadableFileError(f"{name}: 'quality' holds {quality.dtype}, not flags")
    last = VALUES[one][-1]
    whole = (abs(data[one]) < np.inf).all(last).transpose(*dataset.SAMPLE_DIMS).values
    height_m = data[dataset.HEIGHT].transpose(*dataset.SAMPLE_DIMS).values
    spoilt = dataset.usable(data).transpose(*dataset.SAMPLE_DIMS).values & ~(
        whole & ~np.isinf(height_m)
    )
    faults = list(data.attrs.get("faults", []))
    if spoilt.any():
        marked = quality.copy(data=np.where(spoilt, int(Quality.DAMAGED), quality.values))
        data = data.assign({dataset.QUALITY: marked.astype(quality.dtype)})
        data[dataset.QUALITY].attrs.update(quality.attrs)
        named = dataset.samples_at(data, spoilt)
        if not accept_damaged:
            raise DamagedSurveyError(
                f"{name} is damaged: {len(named)} samples that should be good hold values that are "
                f"no numbers ({'; '.join(named[:3])}{', ...' if len(named) > 3 else ''}). {ACCEPT}"
            )
        data = data.assign({one: data[one].where(~(quality.copy(data=spoilt)))})
        faults += [f"{name}: {place} holds values that are no numbers" for place in named]
    lists = {"missing": dataset.missing_samples(data), "faults": faults}
    # Samples that a step filled in are good by now, but were not measured: their names stay.
    lists["missing"] = list(dict.fromkeys([*data.attrs.get("missing", []), *lists["missing"]]))
    return data.assign_attrs({"notes": [], **data.attrs, **lists})
