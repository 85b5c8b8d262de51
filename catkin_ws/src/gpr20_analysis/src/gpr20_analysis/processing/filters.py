"""Filters over time and over space: dewow, and the f-k filter by dip."""

from __future__ import annotations

import enum

import numpy as np
import scipy.fft
import xarray as xr
from scipy.ndimage import uniform_filter1d

from gpr20_analysis import faults
from gpr20_analysis.dataset import (
    A_SCAN,
    DELAY,
    FREQUENCY,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    require,
    require_complete,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S

# Of the distance between two positions.
STEP_TOLERANCE = 1e-3
FEWEST_POSITIONS = 3


class Along(enum.Enum):
    """The axis along which dips are measured."""

    X = "x"
    Y = "y"


def dewow(survey: xr.Dataset, window_s: float = 2e-9) -> xr.Dataset:
    """Subtract from each trace its running mean over time.

    This removes what changes more slowly than the window: offset and drift of a time-domain
    receiver. In spectra the running mean is a factor for each frequency, sinc(f * window), so
    they stay spectra and can be imaged.

    Args:
        survey: Dataset with `s21` or `a_scan`.
        window_s: Width of the running mean [s].

    Raises:
        WrongDatasetError: The window is not positive, or shorter than three samples.
    """
    if not window_s > 0.0:
        raise WrongDatasetError(
            Message(
                "the window of dewow is {window_s:g} s; it must be more than 0", window_s=window_s
            ),
            fault=NOT_ALLOWED,
        )
    if S21 in survey:
        measured = require(survey, S21, S21_DIMS)
        kept = 1.0 - np.sinc(survey[FREQUENCY].values * window_s)
        return survey.assign({S21: measured.copy(data=measured.values * kept)})
    traces = require(survey, A_SCAN, (*SAMPLE_DIMS, DELAY))
    step_s = float(survey[DELAY][1] - survey[DELAY][0])
    width = 2 * int(window_s / step_s / 2.0) + 1
    if width < 3:
        raise WrongDatasetError(
            Message(
                "the window of dewow is {window_s:g} s, but samples are {step_s:g} s apart; use at "
                "least three samples",
                window_s=window_s,
                step_s=step_s,
            ),
            fault=NOT_ALLOWED,
        )
    values = traces.values
    return survey.assign({A_SCAN: traces.copy(data=values - _running_mean(values, width))})


def _running_mean(values: np.ndarray, width: int) -> np.ndarray:
    """Return the mean over a window along the last axis, narrower at the ends."""
    every = uniform_filter1d(np.ones(values.shape[-1]), width, mode="constant")
    parts = [
        uniform_filter1d(part, width, axis=-1, mode="constant") / every
        for part in ((values.real, values.imag) if np.iscomplexobj(values) else (values,))
    ]
    mean: np.ndarray = parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]
    return mean


def filter_dips(
    survey: xr.Dataset,
    along: Along = Along.X,
    least_deg: float = 0.0,
    most_deg: float = 90.0,
    taper_deg: float = 5.0,
) -> xr.Dataset:
    """Keep the waves that arrive within a range of dips: a fan filter over f and k.

    A wave that arrives at the angle `dip` to the vertical in air has the spatial frequency
    |k| = 2 f sin(dip) / c along the axis, so its apparent velocity is c / (2 sin(dip)). What no
    wave in air can have, |k| > 2 f / c, is always removed.

    Args:
        survey: Dataset with `s21`, evenly spaced along the axis, without missing samples.
        along: The axis.
        least_deg: Smallest dip that is kept [deg]; more than 0 removes flat echoes.
        most_deg: Largest dip that is kept [deg].
        taper_deg: Width of the edges outside the range, where the weight falls to 0 [deg].

    Raises:
        WrongDatasetError: A value is not allowed, or the positions are not evenly spaced.
        DamagedSurveyError: A sample is missing.
    """
    if not (0.0 <= least_deg < most_deg <= 90.0 and 0.0 <= taper_deg <= 45.0):
        raise WrongDatasetError(
            Message(
                "the dips of the f-k filter are {least:g} to {most:g} deg with edges of {taper:g} "
                "deg; they must ascend from 0 to 90 deg, with edges of 0 to 45 deg",
                least=least_deg,
                most=most_deg,
                taper=taper_deg,
            ),
            fault=NOT_ALLOWED,
        )
    measured = require(survey, S21, S21_DIMS)
    require_complete(survey, Message("the f-k filter"))
    axis = along.value
    step_m = _even_step_m(survey, axis)
    count = scipy.fft.next_fast_len(2 * survey.sizes[axis])
    sine = (
        0.5
        * SPEED_OF_LIGHT_M_S
        * np.abs(scipy.fft.fftfreq(count, step_m))[:, None]
        / survey[FREQUENCY].values
    )
    weights = fan(sine, least_deg, most_deg, taper_deg)

    place = S21_DIMS.index(axis)
    values = np.moveaxis(measured.values, place, -2)
    spectrum = scipy.fft.fft(values, count, axis=-2)
    spectrum *= weights
    kept = scipy.fft.ifft(spectrum, axis=-2)[..., : values.shape[-2], :]
    return survey.assign({S21: measured.copy(data=np.moveaxis(kept, -2, place))})


def fan(sine: np.ndarray, least_deg: float, most_deg: float, taper_deg: float) -> np.ndarray:
    """Return the weight of each sine of a dip; 0 above 1."""
    dip_deg = np.degrees(np.arcsin(np.minimum(sine, 1.0)))
    outside_deg = np.maximum(np.maximum(least_deg - dip_deg, dip_deg - most_deg), 0.0)
    if taper_deg > 0.0:
        edge = np.cos(0.5 * np.pi * np.minimum(outside_deg / taper_deg, 1.0)) ** 2
    else:
        edge = np.where(outside_deg > 0.0, 0.0, 1.0)
    return np.where(sine > 1.0, 0.0, edge)


def _even_step_m(survey: xr.Dataset, axis: str) -> float:
    places_m = np.asarray(survey[axis].values, dtype=np.float64)
    steps_m = np.diff(places_m)
    if len(places_m) < FEWEST_POSITIONS or np.ptp(steps_m) > STEP_TOLERANCE * abs(steps_m[0]):
        raise WrongDatasetError(
            Message(
                "the f-k filter needs at least {fewest} evenly spaced positions along {axis}",
                fewest=FEWEST_POSITIONS,
                axis=axis,
            ),
            fault=faults.STEPS,
        )
    return float(np.mean(steps_m))
