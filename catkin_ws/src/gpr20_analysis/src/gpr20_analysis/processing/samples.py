"""What becomes of samples: missing ones filled in, polarizations selected and combined."""

from __future__ import annotations

import enum

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from gpr20_analysis import faults
from gpr20_analysis.dataset import (
    A_SCAN,
    HEIGHT,
    POLARIZATION,
    QUALITY,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    require,
    usable,
)
from gpr20_analysis.errors import DamagedSurveyError, WrongDatasetError
from gpr20_analysis.sentences import with_notes, with_sentence
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message, numeral

FILLED = "filled"
"""Variable: which samples were interpolated from neighbours, bool (polarization, y, x)."""
MOST_FILLED = 0.05
ROTATION_TOLERANCE_DEG = 0.5
COMBINED = "polarizations"
"""Attribute: how a polarization was combined of two."""


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
    measured = require(survey, S21, S21_DIMS)
    height_m = require(survey, HEIGHT, SAMPLE_DIMS).values.copy()
    whole = np.isfinite(measured.values).all(axis=-1)
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
    held = _filled(np.where(present[..., None], measured.values, np.nan))
    height_m = _filled(np.where(known, height_m, np.nan)[..., np.newaxis])[..., 0]
    quality = survey[QUALITY].transpose(*SAMPLE_DIMS)
    filled = survey.assign(
        {
            S21: measured.copy(data=held),
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
        filled[turn, row, column] = values[around][present[around]].mean(axis=0)
    return filled


class Combination(enum.Enum):
    """How two polarizations become one."""

    SUM = "sum"
    """Independent of the orientation of a target."""
    DIFFERENCE = "difference"
    """Shows targets that reflect one polarization more, such as elongated ones."""


def select_polarization(survey: xr.Dataset, rotation_deg: float) -> xr.Dataset:
    """Select one polarization.

    Raises:
        WrongDatasetError: It was not measured.
    """
    turns = survey[POLARIZATION].values
    near = np.flatnonzero(np.abs(turns - rotation_deg) <= ROTATION_TOLERANCE_DEG)
    if near.size == 0:
        raise WrongDatasetError(
            Message(
                "rotation {rotation_deg:g} deg was not measured; the data have {rotations} deg",
                rotation_deg=rotation_deg,
                rotations=tuple(map(numeral, turns)),
            ),
            fault=NOT_ALLOWED,
        )
    return survey.isel({POLARIZATION: near[:1]})


def combine_polarizations(survey: xr.Dataset, method: Combination = Combination.SUM) -> xr.Dataset:
    """Combine the two polarizations of a survey into one; its rotation is NaN.

    A sample that is missing in one of them is missing. The height is the mean of both.

    Raises:
        WrongDatasetError: The data do not have two polarizations.
    """
    turns = survey[POLARIZATION].values
    if len(turns) != 2:
        raise WrongDatasetError(
            Message(
                "the data have {count} polarizations; a combination needs two", count=len(turns)
            )
        )
    first, second = (survey.isel({POLARIZATION: index}, drop=True) for index in (0, 1))
    variable_name = S21 if S21 in survey else A_SCAN
    sign = 1.0 if method is Combination.SUM else -1.0
    combined = xr.Dataset(
        {
            variable_name: (first[variable_name] + sign * second[variable_name]) / 2.0,
            HEIGHT: (first[HEIGHT] + second[HEIGHT]) / 2.0,
            QUALITY: first[QUALITY] | second[QUALITY],
        },
        attrs=dict(survey.attrs),
    )
    for kept, variable in survey.data_vars.items():
        if kept not in combined and variable.dims == SAMPLE_DIMS and variable.dtype.kind == "f":
            combined[kept] = (first[kept] + second[kept]) / 2.0
        elif kept not in combined and variable.dtype.kind == "b":
            combined[kept] = first[kept] | second[kept]
    combined = combined.expand_dims({POLARIZATION: [np.nan]})
    for kept in combined.variables:
        combined[kept].attrs.update(survey[kept].attrs)
    values = {"first_deg": turns[0], "second_deg": turns[1]}
    if method is Combination.SUM:
        name = Message("sum of {first_deg:g} and {second_deg:g} deg", **values)
    else:
        name = Message("difference of {first_deg:g} and {second_deg:g} deg", **values)
    return combined.assign_attrs(with_sentence(combined.attrs, COMBINED, name))
