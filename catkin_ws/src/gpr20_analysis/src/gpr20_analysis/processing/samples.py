"""Polarizations: one selected, two combined, and a reference of the same ones."""

from __future__ import annotations

import enum

import numpy as np
import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.dataset import (
    A_SCAN,
    FREQUENCY,
    POLARIZATION,
    S21,
    SAMPLE_DIMS,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.sentences import with_sentence
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message, numeral

ROTATION_TOLERANCE_DEG = 0.5
# Of the sweep's step.
FREQUENCY_TOLERANCE = 1e-3
COMBINED = "polarizations"
"""Attribute: how a polarization was combined of two."""


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


def matched(reference: xr.Dataset, survey: xr.Dataset) -> xr.Dataset:
    """Return those rotations of a reference that a survey has, with the survey's coordinates.

    Raises:
        WrongDatasetError: It has another sweep, or lacks a rotation.
    """
    own_hz, other_hz = (one[FREQUENCY].values for one in (survey, reference))
    off_deg = np.abs(survey[POLARIZATION].values[:, None] - reference[POLARIZATION].values)
    most_hz = FREQUENCY_TOLERANCE * float(np.ptp(own_hz)) / max(len(own_hz) - 1, 1)
    # Written so that NaN is refused too.
    if not (
        own_hz.shape == other_hz.shape
        and np.all(np.abs(own_hz - other_hz) <= most_hz)
        and np.all(off_deg.min(axis=1) <= ROTATION_TOLERANCE_DEG)
    ):
        raise WrongDatasetError(
            Message(
                "the reference was measured at {reference}, the survey at {survey}; measure both "
                "with the same sweep and rotations",
                reference=_settings(reference),
                survey=_settings(survey),
            ),
            fault=faults.INPUT,
        )
    found = reference.isel({POLARIZATION: off_deg.argmin(axis=1)})
    return found.assign_coords({name: survey[name] for name in (POLARIZATION, FREQUENCY)})


def _settings(data: xr.Dataset) -> Message:
    frequency_hz = data[FREQUENCY].values
    return Message(
        "{start_hz:g} to {stop_hz:g} Hz, {count} points, {rotations} deg",
        start_hz=frequency_hz[0],
        stop_hz=frequency_hz[-1],
        count=len(frequency_hz),
        rotations=tuple(map(numeral, data[POLARIZATION].values)),
    )


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
    sign = 1.0 if method is Combination.SUM else -1.0
    combined = xr.Dataset(attrs=dict(survey.attrs))
    for name, variable in survey.data_vars.items():
        if variable.dims != SAMPLE_DIMS and name not in (S21, A_SCAN):
            continue
        first, second = (variable.isel({POLARIZATION: index}, drop=True) for index in (0, 1))
        if variable.dtype.kind in "fc":
            combined[name] = (first + (sign if name in (S21, A_SCAN) else 1.0) * second) / 2.0
        elif variable.dtype.kind in "bu":
            combined[name] = first | second
    combined = combined.expand_dims({POLARIZATION: [np.nan]})
    for kept in combined.variables:
        combined[kept].attrs.update(survey[kept].attrs)
    values = {"first_deg": turns[0], "second_deg": turns[1]}
    if method is Combination.SUM:
        name = Message("sum of {first_deg:g} and {second_deg:g} deg", **values)
    else:
        name = Message("difference of {first_deg:g} and {second_deg:g} deg", **values)
    return combined.assign_attrs(with_sentence(combined.attrs, COMBINED, name))
