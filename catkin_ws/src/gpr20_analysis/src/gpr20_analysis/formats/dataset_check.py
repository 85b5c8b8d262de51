"""Check of a Dataset read from a file: damaged data are refused or marked, never used."""

from __future__ import annotations

from typing import Dict, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import DamagedSurveyError, UnreadableFileError
from gpr20_analysis.faults import FILE_DAMAGED, INPUT
from gpr20_analysis.read.doubts import survey_doubts
from gpr20_analysis.sentences import first_of, sentences_of, with_doubts, with_sentences
from gpr20_common.message import Message

VALUES: Dict[str, Tuple[str, ...]] = {
    dataset.S21: dataset.S21_DIMS,
    dataset.A_SCAN: (*dataset.SAMPLE_DIMS, dataset.DELAY),
    dataset.IMAGE: (dataset.POLARIZATION, dataset.DEPTH, dataset.Y, dataset.X),
    dataset.ANTENNA: dataset.ANTENNA_DIMS,
}
"""The variables that a Dataset may have, and their dimensions."""
ASCENDING = (dataset.Y, dataset.X, dataset.FREQUENCY, dataset.DELAY, dataset.DEPTH)


def checked(data: xr.Dataset, name: str, accept_damaged: bool = False) -> xr.Dataset:
    """Return a Dataset as `gpr20_analysis.dataset` describes it, or refuse it.

    Attribute `missing` names every sample without data, even if the file did not.

    Args:
        data: Content of a file, in memory or lazy.
        name: Name of the file, for messages.
        accept_damaged: Mark usable samples that contain NaN as damaged instead of refusing.

    Raises:
        UnreadableFileError: It contains neither spectra nor A-scans nor an image.
        DamagedSurveyError: Values of usable samples are NaN or infinite.
    """
    held = [one for one in VALUES if one in data]
    if not held:
        raise UnreadableFileError(
            Message(
                "{file} was not written by gpr20: it contains none of {needed}, only: {names}",
                file=name,
                needed=", ".join(VALUES),
                names=", ".join(sorted(map(str, data.data_vars))) or "-",
            ),
            fault=INPUT,
        )
    for one in held:
        dims = tuple(data[one].dims)
        if set(dims) != set(VALUES[one]) or 0 in data[one].shape:
            raise UnreadableFileError(
                Message(
                    "{file}: '{variable}' has the dimensions {found}; it must have {needed}, none "
                    "of them empty",
                    file=name,
                    variable=one,
                    found=", ".join(f"{dim} {size}" for dim, size in data[one].sizes.items()),
                    needed=", ".join(VALUES[one]),
                ),
                fault=INPUT,
            )
        _check_axes(data, one, name)
    whole = [one for one in held if one in (dataset.IMAGE, dataset.ANTENNA)]
    if not all(bool(np.isfinite(data[one]).all()) for one in whole):
        raise DamagedSurveyError(
            Message("{file} is damaged: it contains NaN or infinite values", file=name),
            fault=FILE_DAMAGED,
        )
    sampled = [one for one in held if one not in whole]
    for one in sampled:
        data = _check_samples(data, one, name, accept_damaged)
    return data


def _check_axes(data: xr.Dataset, one: str, name: str) -> None:
    for axis in VALUES[one]:
        values = data[axis].values if axis in data.coords else None
        if values is None or values.dtype.kind not in "fiu":
            raise UnreadableFileError(
                Message("{file} has no coordinate '{axis}'", file=name, axis=axis),
                fault=INPUT,
            )
        if axis in ASCENDING and not (
            np.isfinite(values).all() and (np.diff(values.astype(np.float64)) > 0).all()
        ):
            raise DamagedSurveyError(
                Message(
                    "{file} is damaged: the values of '{axis}' are not ascending",
                    file=name,
                    axis=axis,
                ),
                fault=FILE_DAMAGED,
            )


def _check_samples(data: xr.Dataset, one: str, name: str, accept_damaged: bool) -> xr.Dataset:
    for variable in (dataset.QUALITY, dataset.HEIGHT):
        if variable not in data or set(data[variable].dims) != set(dataset.SAMPLE_DIMS):
            raise UnreadableFileError(
                Message(
                    "{file} has no '{variable}' for each sample of '{values}'",
                    file=name,
                    variable=variable,
                    values=one,
                ),
                fault=INPUT,
            )
    quality = data[dataset.QUALITY].transpose(*dataset.SAMPLE_DIMS)
    if quality.dtype.kind not in "ui":
        raise UnreadableFileError(
            Message(
                "{file}: 'quality' is of type {type} instead of integer flags",
                file=name,
                type=quality.dtype,
            ),
            fault=INPUT,
        )
    last = VALUES[one][-1]
    whole = (abs(data[one]) < np.inf).all(last).transpose(*dataset.SAMPLE_DIMS).values
    height_m = data[dataset.HEIGHT].transpose(*dataset.SAMPLE_DIMS).values
    spoilt = dataset.usable(data).transpose(*dataset.SAMPLE_DIMS).values & ~(
        whole & ~np.isinf(height_m)
    )
    faults = sentences_of(data, "faults")
    if spoilt.any():
        marked = quality.copy(data=np.where(spoilt, int(Quality.DAMAGED), quality.values))
        data = data.assign({dataset.QUALITY: marked.astype(quality.dtype)})
        data[dataset.QUALITY].attrs.update(quality.attrs)
        positions = dataset.positions_of(data, spoilt)
        if not accept_damaged:
            raise DamagedSurveyError(
                Message(
                    "{file} is damaged: {count} samples that are marked as good contain NaN or "
                    "infinite values ({samples}); leave them out with --accept-damaged",
                    file=name,
                    count=len(positions),
                    samples=first_of(positions, dataset.NAMED),
                ),
                fault=FILE_DAMAGED,
            )
        data = data.assign({one: data[one].where(~(quality.copy(data=spoilt)))})
        faults += [
            Message("{file}: {position}: NaN or infinite values", file=name, position=position)
            for position in positions
        ]
        data = with_doubts(data, *survey_doubts({}, (), len(positions)))
    # Samples that a step filled in are usable, but were not measured: they stay in the list.
    missing = [*sentences_of(data, "missing"), *dataset.missing_samples(data)]
    missing = list({str(one): one for one in missing}.values())
    attributes = {"notes": [], **data.attrs}
    return data.assign_attrs(with_sentences(attributes, missing=missing, faults=faults))
