"""Polarizations: one selected, and a reference of the same ones."""

from __future__ import annotations

import numpy as np
import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.dataset import (
    FREQUENCY,
    HZ_PER_MHZ,
    POLARIZATION,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message, numeral

ROTATION_TOLERANCE_DEG = 0.5
# Of the sweep's step.
FREQUENCY_TOLERANCE = 1e-3


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
        "{start_mhz:g} to {stop_mhz:g} MHz, {count} points, {rotations} deg",
        start_mhz=frequency_hz[0] / HZ_PER_MHZ,
        stop_mhz=frequency_hz[-1] / HZ_PER_MHZ,
        count=len(frequency_hz),
        rotations=tuple(map(numeral, data[POLARIZATION].values)),
    )
