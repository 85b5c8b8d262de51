"""Interpolation of missing samples."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from gpr20_analysis import faults, lazy
from gpr20_analysis.dataset import (
    FREQUENCY,
    HEIGHT,
    QUALITY,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    require,
    usable,
)
from gpr20_analysis.errors import DamagedSurveyError, WrongDatasetError
from gpr20_analysis.sentences import with_notes
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message

FILLED = "filled"
"""Variable: which samples were interpolated from neighbours, bool (polarization, y, x)."""
MOST_FILLED = 0.05


def fill_missing(survey: xr.Dataset, most: float = MOST_FILLED) -> xr.Dataset:
    """Fill missing samples and heights with the mean of their neighbours in the grid.

    Filled samples are marked in `filled` and counted in attribute `notes`, so that every figure
    says that not all of its data were measured.

    Args:
        survey: The survey.
        most: Largest share of samples that may be missing.

    Raises:
        DamagedSurveyError: More are missing, or no neighbour of a sample was measured.
        WrongDatasetError: `most` is not within 0..1.
    """
    if not 0.0 <= most <= 1.0:
        raise WrongDatasetError(
            Message("the share that may be filled is {share:g}; it must be 0 to 1", share=most),
            fault=NOT_ALLOWED,
        )
    measured = lazy.in_rows(require(survey, S21, S21_DIMS))
    height_m = require(survey, HEIGHT, SAMPLE_DIMS).values.copy()
    whole = (abs(measured) < np.inf).all(FREQUENCY).values
    present = usable(survey).transpose(*SAMPLE_DIMS).values & whole
    absent = ~present
    if np.mean(absent) > most:
        raise DamagedSurveyError(
            Message(
                "{count} of {total} samples are missing, more than the share of {share:g} that may "
                "be filled; measure them, or make the image without them",
                count=np.count_nonzero(absent),
                total=absent.size,
                share=most,
            ),
            fault=faults.INPUT,
        )
    _check_neighbours(present)
    known = present & np.isfinite(height_m)
    _check_neighbours(known)
    here = lazy.beside(xr.DataArray(present, dims=SAMPLE_DIMS), measured)
    held = lazy.with_neighbours(_filled, measured.where(here), 1)
    height_m = _filled(np.where(known, height_m, np.nan)[..., np.newaxis])[..., 0]
    quality = survey[QUALITY].transpose(*SAMPLE_DIMS)
    filled = survey.assign(
        {
            S21: held.assign_attrs(survey[S21].attrs),
            HEIGHT: (SAMPLE_DIMS, height_m, survey[HEIGHT].attrs),
            FILLED: (SAMPLE_DIMS, absent),
            # Filled samples are usable; `filled` says that they were not measured.
            QUALITY: quality.where(~absent, 0).astype(quality.dtype).assign_attrs(quality.attrs),
        }
    )
    count, heights = int(np.count_nonzero(absent)), int(np.count_nonzero(~known))
    if count or heights:
        note = Message(
            "{count} samples and {heights} heights were interpolated from their neighbours",
            count=count,
            heights=heights,
        )
        filled = filled.assign_attrs(with_notes(survey, [note]))
    return filled


def _check_neighbours(present: np.ndarray) -> None:
    neighbours = maximum_filter(present, size=(1, 3, 3), mode="constant")
    alone = np.argwhere(~neighbours)
    if len(alone):
        turn, row, column = alone[0]
        raise DamagedSurveyError(
            Message(
                "the sample in row {row}, column {column} of polarization {polarization} and all "
                "of its neighbours are missing, so it cannot be interpolated; measure them, or "
                "make the image without them",
                row=row,
                column=column,
                polarization=turn,
            ),
            fault=faults.INPUT,
        )


def _filled(values: np.ndarray) -> np.ndarray:
    """Return (polarization, y, x, any) with the mean of up to 8 neighbours where a trace is NaN."""
    present = np.all(np.isfinite(values), axis=-1)
    filled = values.copy()
    for turn, row, column in np.argwhere(~present):
        around = (turn, slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2))
        # Rows that are read only as neighbours may have no neighbours themselves.
        if np.any(present[around]):
            filled[turn, row, column] = values[around][present[around]].mean(axis=0)
    return filled
