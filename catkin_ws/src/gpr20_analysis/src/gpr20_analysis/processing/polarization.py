"""Combinations of the polarizations, and gain for display."""

from __future__ import annotations

import enum

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter1d

from gpr20_analysis import lazy
from gpr20_analysis.dataset import A_SCAN, DELAY, HEIGHT, POLARIZATION, QUALITY, S21, SAMPLE_DIMS
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.sentences import with_sentence
from gpr20_common.message import Message

ROTATION_TOLERANCE_DEG = 0.5
COMBINED = "polarizations"
"""Attribute: how a polarization was combined of two."""
DISPLAY_ONLY = "display_only"
"""Attribute: why the amplitudes are for display only and must not be imaged."""


class Combination(enum.Enum):
    """How two polarizations become one."""

    SUM = "sum"
    """Independent of the orientation of a target."""
    DIFFERENCE = "difference"
    """Shows targets that reflect one polarization more, such as elongated ones."""


class Gain(enum.Enum):
    """How late echoes are amplified."""

    LINEAR = "linear"
    """Proportional to the delay: compensates for spreading."""
    EXPONENTIAL = "exponential"
    """A number of decibels per nanosecond: compensates for loss."""
    AGC = "agc"
    """Each value divided by the root mean square of those around it."""


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
                rotations=", ".join(f"{turn:g}" for turn in turns),
            )
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


def apply_gain(
    in_time: xr.Dataset, method: Gain = Gain.LINEAR, db_per_ns: float = 1.0, window_s: float = 2e-9
) -> xr.Dataset:
    """Amplify late echoes for display; imaging refuses the result.

    Args:
        in_time: Dataset with `a_scan`.
        method: How the echoes are amplified.
        db_per_ns: Slope of the exponential gain [dB/ns].
        window_s: Width of the window of the automatic gain [s].

    Raises:
        WrongDatasetError: The data are not A-scans.
    """
    if A_SCAN not in in_time:
        raise WrongDatasetError(
            Message("the step gain needs A-scans; apply the step 'time' before it")
        )
    delay_s = in_time[DELAY]
    values = in_time[A_SCAN]
    if method is Gain.AGC:
        step_s = float(delay_s[1] - delay_s[0])
        values = lazy.in_rows(values.transpose(*SAMPLE_DIMS, DELAY))
        power = xr.apply_ufunc(
            _mean_power,
            values,
            input_core_dims=[[DELAY]],
            output_core_dims=[[DELAY]],
            kwargs={"width": max(1, round(window_s / step_s))},
            dask="parallelized",
            output_dtypes=[np.float64],
        )
        raised = values / np.sqrt(power + 1e-12 * float(power.max()))
    elif method is Gain.EXPONENTIAL:
        raised = values * 10.0 ** (db_per_ns * delay_s * 1e9 / 20.0)
    else:
        raised = values * (delay_s / float(delay_s.max()))
    result = in_time.assign({A_SCAN: raised.transpose(*values.dims)})
    reason = Message("gain {method}", method=method.value)
    return result.assign_attrs(with_sentence(result.attrs, DISPLAY_ONLY, reason))


def _mean_power(values: np.ndarray, width: int) -> np.ndarray:
    """Return the mean power over a window around each sample, narrower at the ends."""
    power, every = np.abs(values) ** 2, np.ones(values.shape[-1])
    mean, share = (uniform_filter1d(one, width, mode="constant") for one in (power, every))
    return mean / share
