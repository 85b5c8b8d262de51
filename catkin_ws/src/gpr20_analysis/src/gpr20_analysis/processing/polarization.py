"""Combinations of the polarizations, and gain for display."""

from __future__ import annotations

import enum

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter1d

from gpr20_analysis import lazy
from gpr20_analysis.dataset import A_SCAN, DELAY, HEIGHT, POLARIZATION, QUALITY, S21, SAMPLE_DIMS
from gpr20_analysis.errors import WrongDatasetError

ROTATION_TOLERANCE_DEG = 0.5
DISPLAY_ONLY = "display_only"
"""Attribute: the amplitudes were changed for the eye; nothing may be computed from them."""


class Combination(enum.Enum):
    """How two polarizations become one."""

    SUM = "sum"
    """Does not depend on how a target lies."""
    DIFFERENCE = "difference"
    """Shows what reflects one polarization more: elongated targets."""


class Gain(enum.Enum):
    """How late echoes are raised."""

    LINEAR = "linear"
    """In proportion to the delay: against spreading."""
    EXPONENTIAL = "exponential"
    """By so many decibels per nanosecond: against loss."""
    AGC = "agc"
    """Each sample over the root mean square of those about it."""


def select_polarization(survey: xr.Dataset, rotation_deg: float) -> xr.Dataset:
    """Keep one polarization.

    Raises:
        WrongDatasetError: It was not measured.
    """
    turns = survey[POLARIZATION].values
    near = np.flatnonzero(np.abs(turns - rotation_deg) <= ROTATION_TOLERANCE_DEG)
    if near.size == 0:
        raise WrongDatasetError(
            f"rotation {rotation_deg:g} deg was not measured; the data hold "
            f"{', '.join(f'{turn:g}' for turn in turns)} deg"
        )
    return survey.isel({POLARIZATION: near[:1]})


def combine_polarizations(survey: xr.Dataset, method: Combination = Combination.SUM) -> xr.Dataset:
    """Combine the two polarizations of a survey into one; its rotation is NaN.

    A sample that one of them lacks is missing. The height is the mean of both.

    Raises:
        WrongDatasetError: The data do not hold two polarizations.
    """
    turns = survey[POLARIZATION].values
    if len(turns) != 2:
        raise WrongDatasetError(
            f"the data hold {len(turns)} polarizations; a combination needs two"
        )
    first, second = (survey.isel({POLARIZATION: index}, drop=True) for index in (0, 1))
    name = S21 if S21 in survey else A_SCAN
    sign = 1.0 if method is Combination.SUM else -1.0
    combined = xr.Dataset(
        {
            name: (first[name] + sign * second[name]) / 2.0,
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
    combined.attrs["polarizations"] = f"{method.value} of {turns[0]:g} and {turns[1]:g} deg"
    return combined


def apply_gain(
    in_time: xr.Dataset, method: Gain = Gain.LINEAR, db_per_ns: float = 1.0, window_s: float = 2e-9
) -> xr.Dataset:
    """Raise late echoes for display; imaging refuses the result.

    Args:
        in_time: Dataset with `a_scan`.
        method: How.
        db_per_ns: Of the exponential gain [dB/ns].
        window_s: Of the automatic gain [s].

    Raises:
        WrongDatasetError: The data are not A-scans.
    """
    if A_SCAN not in in_time:
        raise WrongDatasetError("gain works on A-scans; put the step 'time' before it")
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
    result.attrs[DISPLAY_ONLY] = f"gain {method.value}"
    return result


def _mean_power(values: np.ndarray, width: int) -> np.ndarray:
    """Return the mean power of so many samples about each, fewer at the ends."""
    power, every = np.abs(values) ** 2, np.ones(values.shape[-1])
    mean, share = (uniform_filter1d(one, width, mode="constant") for one in (power, every))
    return mean / share
