"""Samples that are missing: filling them in, and saying so."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from gpr20_analysis import lazy
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

FILLED = "filled"
"""Variable: which samples were made from their neighbours, bool (polarization, y, x)."""
MOST_FILLED = 0.05


def fill_missing(survey: xr.Dataset, most: float = MOST_FILLED) -> xr.Dataset:
    """Fill missing samples and heights with the mean of their neighbours in the grid.

    What was filled is marked in `filled` and counted in attribute `notes`, so that no picture
    passes for measured throughout.

    Args:
        survey: The survey.
        most: Refuse if a larger share than this is missing.

    Raises:
        DamagedSurveyError: More is missing, or a sample has no neighbour that was measured.
        WrongDatasetError: `most` is not within 0..1.
    """
    if not 0.0 <= most <= 1.0:
        raise WrongDatasetError(f"the share that may be filled is {most:g}; it must be 0..1")
    measured = lazy.in_rows(require(survey, S21, S21_DIMS))
    height_m = require(survey, HEIGHT, SAMPLE_DIMS).values.copy()
    whole = (abs(measured) < np.inf).all(FREQUENCY).values
    present = usable(survey).transpose(*SAMPLE_DIMS).values & whole
    absent = ~present
    if np.mean(absent) > most:
        raise DamagedSurveyError(
            f"{np.count_nonzero(absent)} of {absent.size} samples are missing, more than the share "
            f"{most:g} that may be filled; measure them, or image with them left out"
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
            # What is filled holds numbers; `filled` says that they were not measured.
            QUALITY: quality.where(~absent, 0).astype(quality.dtype).assign_attrs(quality.attrs),
        }
    )
    count, heights = int(np.count_nonzero(absent)), int(np.count_nonzero(~known))
    if count or heights:
        note = f"{count} samples and {heights} heights were filled in from their neighbours"
        filled.attrs["notes"] = [*survey.attrs.get("notes", []), note]
    return filled


def _check_neighbours(present: np.ndarray) -> None:
    neighbours = maximum_filter(present, size=(1, 3, 3), mode="constant")
    alone = np.argwhere(~neighbours)
    if len(alone):
        turn, row, column = alone[0]
        raise DamagedSurveyError(
            f"the sample in row {row}, column {column} of polarization {turn} and all of its "
            "neighbours are missing; there is nothing to fill it from"
        )


def _filled(values: np.ndarray) -> np.ndarray:
    """Return (polarization, y, x, any) with the mean of up to 8 neighbours where a trace is NaN."""
    present = np.all(np.isfinite(values), axis=-1)
    filled = values.copy()
    for turn, row, column in np.argwhere(~present):
        around = (turn, slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2))
        # Rows that are only seen for their neighbours' sake may have none themselves.
        if np.any(present[around]):
            filled[turn, row, column] = values[around][present[around]].mean(axis=0)
    return filled
