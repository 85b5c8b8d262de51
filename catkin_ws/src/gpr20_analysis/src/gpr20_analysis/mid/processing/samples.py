"""Samples that are missing: filling them in, and saying so."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.ndimage import convolve

from gpr20_analysis.errors import DamagedSurveyError, WrongDatasetError
from gpr20_analysis.mid.dataset import HEIGHT, QUALITY, S21, S21_DIMS, SAMPLE_DIMS, require, usable

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
    measured = require(survey, S21, S21_DIMS).values.copy()
    height_m = require(survey, HEIGHT, SAMPLE_DIMS).values.copy()
    present = usable(survey).transpose(*SAMPLE_DIMS).values & np.all(np.isfinite(measured), -1)
    absent = ~present
    if np.mean(absent) > most:
        raise DamagedSurveyError(
            f"{np.count_nonzero(absent)} of {absent.size} samples are missing, more than the share "
            f"{most:g} that may be filled; measure them, or image with them left out"
        )
    _fill(measured, present)
    known = present & np.isfinite(height_m)
    _fill(height_m[..., None], known)
    quality = survey[QUALITY].transpose(*SAMPLE_DIMS)
    filled = survey.assign(
        {
            S21: (S21_DIMS, measured, survey[S21].attrs),
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


def _fill(values: np.ndarray, present: np.ndarray) -> None:
    """Set what is not present (polarization, y, x, any) to the mean of up to 8 neighbours."""
    around = np.ones((1, 3, 3))
    neighbours = convolve(present.astype(np.int64), around.astype(np.int64), mode="constant")
    for turn, row, column in np.argwhere(~present):
        if neighbours[turn, row, column] == 0:
            raise DamagedSurveyError(
                f"the sample in row {row}, column {column} of polarization {turn} and all of its "
                "neighbours are missing; there is nothing to fill it from"
            )
        window = (turn, slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2))
        values[turn, row, column] = values[window][present[window]].mean(axis=0)
