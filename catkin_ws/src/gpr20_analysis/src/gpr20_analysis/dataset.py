"""The Dataset of a survey: names, units and flags that every step agrees on.

`s21` is complex128 with dimensions (polarization, y, x, frequency); `height`, `timestamp`,
`sweep_started`, `sweep_ended`, `quality`, `remarks`, `sample_id` and `index` have (polarization,
y, x). All units are SI, but rotations are in degrees. A sample that is missing or damaged is NaN
in `s21`; `quality` says which of both, attribute `missing` lists them.
"""

from __future__ import annotations

import enum
from typing import List, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis.errors import DamagedSurveyError, WrongDatasetError

FORMAT = "gpr20-dataset/1"
POLARIZATION, Y, X, FREQUENCY, DELAY, DEPTH = (
    "polarization",
    "y",
    "x",
    "frequency",
    "delay",
    "depth",
)
SAMPLE_DIMS = (POLARIZATION, Y, X)
S21_DIMS = (*SAMPLE_DIMS, FREQUENCY)
S21, A_SCAN, IMAGE = "s21", "a_scan", "image"
HEIGHT, TIMESTAMP, QUALITY = "height", "timestamp", "quality"
LIST_ATTRIBUTES = ("missing", "faults", "notes")
"""Attributes that are lists of sentences."""

MM_PER_M = 1000.0

ATTRIBUTES = {
    POLARIZATION: {"units": "degree", "long_name": "rotation of the antennas"},
    Y: {"units": "m", "long_name": "y"},
    X: {"units": "m", "long_name": "x"},
    FREQUENCY: {"units": "Hz", "long_name": "frequency"},
    DELAY: {"units": "s", "long_name": "two-way delay"},
    DEPTH: {"units": "m", "long_name": "depth below the surface", "positive": "down"},
    S21: {"units": "1", "long_name": "transmission S21"},
    A_SCAN: {"units": "1", "long_name": "A-scan"},
    HEIGHT: {"units": "m", "long_name": "antenna height above the ground"},
    "index": {"long_name": "place in the survey's plan, -1 without a sample"},
    "sample_id": {"long_name": "name of the sample"},
    "remarks": {"long_name": "remarks of the robot on the sample"},
}


class Quality(enum.IntFlag):
    """What is to be known of a sample."""

    GOOD = 0
    MISSING = 1
    """It was never stored, or cannot be read."""
    DAMAGED = 2
    """It is stored, but cannot be trusted; its numbers are left out."""
    NO_HEIGHT = 4
    """The height of the antennas was not measured."""
    REMARKED = 8
    """The robot made remarks; see `remarks`."""


QUALITY_ATTRIBUTES = {
    "long_name": "quality of the sample",
    "flag_masks": [flag.value for flag in Quality if flag],
    "flag_meanings": " ".join(flag.name.lower() for flag in Quality if flag and flag.name),
}
UNUSABLE = Quality.MISSING | Quality.DAMAGED


def described(data: xr.Dataset) -> xr.Dataset:
    """Return a Dataset whose variables say their units and meanings."""
    for name in data.variables:
        data[name].attrs.update(ATTRIBUTES.get(str(name), {}))
    data[QUALITY].attrs.update(QUALITY_ATTRIBUTES)
    return data


def usable(survey: xr.Dataset) -> xr.DataArray:
    """Return which samples hold numbers, bool (polarization, y, x)."""
    return (survey[QUALITY] & int(UNUSABLE)) == 0


def missing_samples(survey: xr.Dataset) -> List[str]:
    """Return one phrase for each sample without numbers: its place, rotation and why."""
    quality = survey[QUALITY].transpose(*SAMPLE_DIMS).values
    absent = (quality & int(UNUSABLE)) != 0
    damaged = (quality[absent] & int(Quality.DAMAGED)) != 0
    return [
        f"{'damaged' if why else 'missing'}: {place}"
        for why, place in zip(damaged, samples_at(survey, absent))
    ]


def samples_at(survey: xr.Dataset, chosen: np.ndarray) -> List[str]:
    """Return the place and rotation of each sample that is chosen, bool (polarization, y, x)."""
    turns_deg, y_m, x_m = (survey[axis].values for axis in SAMPLE_DIMS)
    return [
        f"x {float(x_m[column]) * MM_PER_M:g} mm, y {float(y_m[row]) * MM_PER_M:g} mm, "
        f"{float(turns_deg[turn]):g} deg"
        for turn, row, column in np.argwhere(chosen)
    ]


def require(survey: xr.Dataset, variable: str, dims: Sequence[str]) -> xr.DataArray:
    """Return a variable of a Dataset that must have certain dimensions.

    Raises:
        WrongDatasetError: It is missing or has other dimensions.
    """
    if variable not in survey:
        held = ", ".join(sorted(str(name) for name in survey.data_vars))
        raise WrongDatasetError(f"the data hold no '{variable}'; they hold {held or 'nothing'}")
    if set(survey[variable].dims) != set(dims):
        raise WrongDatasetError(
            f"'{variable}' has dimensions {tuple(survey[variable].dims)}; it must have "
            f"{tuple(dims)}"
        )
    return survey[variable].transpose(*dims)


def require_complete(survey: xr.Dataset, purpose: str) -> None:
    """Check that no sample is missing, for what cannot do without one.

    Raises:
        DamagedSurveyError: A sample is missing or damaged.
    """
    absent = missing_samples(survey)
    if absent:
        raise DamagedSurveyError(
            f"{len(absent)} samples have no numbers ({'; '.join(absent[:3])}"
            f"{', ...' if len(absent) > 3 else ''}); {purpose} needs every one"
        )
