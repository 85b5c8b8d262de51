"""The Dataset of a survey: names, units and flags that all steps use.

`s21` is complex128 with dimensions (polarization, y, x, frequency). `quality` has (polarization, y,
x), and so have `aux_<name>`, the value of another sensor, NaN where there is none, and the fields
of the traces by the names in `gpr20_survey.trace.trace.TRACE_FIELDS`, such as `timestamp`, but for
`height` and `remarks`; `zero_epochs` and `zero_times` have (polarization, y, x, axis). All units
are SI, but rotations are in degrees and sensors have their own. A sample that is missing or damaged
is NaN in `s21`; `quality` says which, and attribute `missing` lists them.
"""

from __future__ import annotations

import enum
import json
from typing import Any, Dict, List, Mapping, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis.errors import WrongDatasetError
from gpr20_common.message import Message
from gpr20_survey.trace.trace import TRACE_FIELDS

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
CLUTTER, ECHOES = "clutter", "echoes"
ANTENNA, TERM = "antenna", "term"
AXIS, AXES = "axis", ("x", "y", "z")
ANTENNA_DIMS = (POLARIZATION, TERM, FREQUENCY)
PROCESSING = "processing"
"""Attribute: the steps by which a Dataset was made, as JSON."""
DISPLAY_ONLY = "display_only"
"""Attribute: why the amplitudes are for display only and must not be imaged."""
OUTSIDE = "samples_outside"
"""How many planned samples without a trace lie around the part of a survey that this is."""
AUX_PREFIX = "aux_"
SIMULATED = "simulated"
"""Attribute: 1 if the data are simulated, 0 if they are measured; absent if nobody knows."""
HEIGHT, TIMESTAMP, QUALITY = "height", "timestamp", "quality"

MM_PER_M = 1000.0
HZ_PER_MHZ = 1e6
NAMED = 3
"""Number of samples that a message about many names."""

ATTRIBUTES: Dict[str, Dict[str, Any]] = {
    **{
        one.name: {"long_name": one.meaning, **({"units": one.unit} if one.unit else {})}
        for one in TRACE_FIELDS
    },
    POLARIZATION: {"units": "degree", "long_name": "rotation of the antennas"},
    Y: {"units": "m", "long_name": "y"},
    X: {"units": "m", "long_name": "x"},
    FREQUENCY: {"units": "Hz", "long_name": "frequency"},
    DELAY: {"units": "s", "long_name": "two-way delay"},
    DEPTH: {
        "units": "m",
        "long_name": "depth below the surface",
        "positive": "down",
        "standard_name": "depth",
    },
    S21: {"units": "1", "long_name": "transmission S21"},
    A_SCAN: {"units": "1", "long_name": "A-scan"},
    HEIGHT: {
        "units": "m",
        "long_name": "antenna height above the ground",
        "positive": "up",
        "standard_name": "height",
    },
    "index": {"long_name": "index in the survey's plan, -1 without a sample"},
    "remarks": {"long_name": "remarks of the robot about the sample"},
    IMAGE: {"units": "1", "long_name": "image"},
    CLUTTER: {"units": "1", "long_name": "clutter beside echoes"},
    ECHOES: {"units": "1", "long_name": "maxima of the image; each value in its own unit"},
}


class Quality(enum.IntFlag):
    """Flags of a sample."""

    GOOD = 0
    MISSING = 1
    """It was not stored, or cannot be read."""
    DAMAGED = 2
    """It is stored but damaged; its values are left out."""
    NO_HEIGHT = 4
    """The height of the antennas was not measured."""
    REMARKED = 8
    """The robot added remarks; see `remarks`."""


ATTRIBUTES[QUALITY] = {
    "long_name": "quality of the sample",
    "flag_masks": np.array([flag.value for flag in Quality if flag], np.uint8),
    "flag_meanings": " ".join(flag.name.lower() for flag in Quality if flag and flag.name),
}
UNUSABLE = Quality.MISSING | Quality.DAMAGED


def described(data: xr.Dataset) -> xr.Dataset:
    """Return a Dataset whose variables have long names, and units if they are numbers."""
    for name in data.variables:
        own = data[name].attrs
        own.update(ATTRIBUTES.get(str(name), {}))
        own.setdefault("long_name", str(name).replace("_", " "))
        if data[name].dtype.kind in "iufc":
            own.setdefault("units", "1")
    return data


def description_of(survey: xr.Dataset) -> Mapping[str, Any]:
    """Return the content of survey.json, of its log the decisions; empty if it is not known."""
    try:
        found = json.loads(survey.attrs.get("survey_json", "{}"))
    except (TypeError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def mapping_of(described: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """Return an entry that is an object; empty if it is none."""
    found = described.get(key)
    return found if isinstance(found, dict) else {}


def objects_of(described: Mapping[str, Any], key: str) -> List[Mapping[str, Any]]:
    """Return the objects in an entry that is a list; none if it is no list."""
    found = described.get(key)
    return [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []


def is_simulated(data: xr.Dataset) -> bool:
    """Return whether the data are known to be simulated."""
    return bool(data.attrs.get(SIMULATED))


def aux_names(survey: xr.Dataset) -> List[str]:
    """Return the names of the variables with values of other sensors."""
    names = [str(name) for name in survey.data_vars if str(name).startswith(AUX_PREFIX)]
    return sorted(name for name in names if set(survey[name].dims) == set(SAMPLE_DIMS))


def usable(survey: xr.Dataset) -> xr.DataArray:
    """Return which samples have data, bool (polarization, y, x)."""
    return (survey[QUALITY] & int(UNUSABLE)) == 0


def missing_samples(survey: xr.Dataset) -> List[Message]:
    """Return a message for each sample without data: missing or damaged, and its position."""
    quality = survey[QUALITY].transpose(*SAMPLE_DIMS).values
    absent = (quality & int(UNUSABLE)) != 0
    damaged = (quality[absent] & int(Quality.DAMAGED)) != 0
    return [
        Message("damaged: {position}", position=position)
        if is_damaged
        else Message("missing: {position}", position=position)
        for is_damaged, position in zip(damaged, positions_of(survey, absent))
    ]


def positions_of(survey: xr.Dataset, chosen: np.ndarray) -> List[Message]:
    """Return the position and rotation of each chosen sample, bool (polarization, y, x)."""
    turns_deg, y_m, x_m = (survey[axis].values for axis in SAMPLE_DIMS)
    return [
        Message(
            "x {x_mm:g} mm, y {y_mm:g} mm, {rotation_deg:g} deg",
            x_mm=float(x_m[column]) * MM_PER_M,
            y_mm=float(y_m[row]) * MM_PER_M,
            rotation_deg=float(turns_deg[turn]),
        )
        for turn, row, column in np.argwhere(chosen)
    ]


def is_line(data: xr.Dataset) -> bool:
    """Return whether the positions are those of a single line, which has no map and no slices."""
    return min(data.sizes[X], data.sizes[Y]) == 1 < max(data.sizes[X], data.sizes[Y])


def require(survey: xr.Dataset, variable: str, dims: Sequence[str]) -> xr.DataArray:
    """Return a variable of a Dataset that must have certain dimensions.

    Raises:
        WrongDatasetError: It is missing or has other dimensions.
    """
    if variable not in survey:
        raise WrongDatasetError(
            Message(
                "the data do not contain '{variable}'; they contain: {names}",
                variable=variable,
                names=", ".join(sorted(str(name) for name in survey.data_vars)) or "-",
            )
        )
    if set(survey[variable].dims) != set(dims):
        raise WrongDatasetError(
            Message(
                "'{variable}' has the dimensions {found}; it must have {needed}",
                variable=variable,
                found=", ".join(map(str, survey[variable].dims)),
                needed=", ".join(dims),
            )
        )
    return survey[variable].transpose(*dims)
