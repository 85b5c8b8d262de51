"""The transform from frequency to time, and the origin of time: antennas, cables, surface."""

from __future__ import annotations

import math
import numbers
from typing import Optional

import numpy as np
import scipy.fft
import xarray as xr

from gpr20_analysis import errors
from gpr20_analysis.dataset import (
    A_SCAN,
    ATTRIBUTES,
    DELAY,
    FREQUENCY,
    HEIGHT,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    positions_of,
    require,
    usable,
)
from gpr20_analysis.errors import DamagedSurveyError, WrongDatasetError
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans, even_delays_s
from gpr20_analysis.read.survey_attributes import (
    ANTENNA_DELAY,
    ANTENNA_SEPARATION,
    WIDEST_SEPARATION_M,
)
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import Window, phase_advance, two_way_delay_s

REMOVED = "antenna_delay_removed_s"
"""Attribute: the delay that the step `antenna` removed from the spectra [s]."""
LONGEST_DELAY_S = 1e-5
"""The record of an impulse radar may begin microseconds before its pulse [s]."""
ADVANCE = "advance"
"""Variable: delay of time zero after that of the antennas, (polarization, y, x) [s]."""


def to_time(survey: xr.Dataset, window: Window = Window.HANN, padding: float = 4.0) -> xr.Dataset:
    """Return A-scans: complex, analytic; their magnitude is the envelope.

    The true frequencies are used, including the start of the sweep, so the phase of an echo is
    that of the measurement. An echo of magnitude 1 at a sampled delay has magnitude 1.

    Args:
        survey: Dataset with `s21`.
        window: Weights over the band.
        padding: Number of samples as a multiple of the number of frequencies.

    Returns:
        Dataset with `a_scan` (polarization, y, x, delay) instead of `s21`.

    Raises:
        WrongDatasetError: The frequencies are not evenly spaced, or the padding is below 1.
    """
    if not padding >= 1.0:
        raise WrongDatasetError(
            Message("the padding is {padding:g}; it must be 1 or more", padding=padding),
            fault=NOT_ALLOWED,
        )
    measured = require(survey, S21, S21_DIMS)
    sweep = FrequencyGrid.of(survey)
    count = scipy.fft.next_fast_len(int(np.ceil(padding * sweep.count)))
    found = a_scans(measured.values, sweep, count, window)
    in_time = survey.drop_vars([S21, FREQUENCY])
    in_time = in_time.assign_coords(
        {DELAY: (DELAY, even_delays_s(sweep, count), ATTRIBUTES[DELAY])}
    )
    return in_time.assign({A_SCAN: ((*SAMPLE_DIMS, DELAY), found, ATTRIBUTES[A_SCAN])})


def set_time_zero(survey: xr.Dataset) -> xr.Dataset:
    """Put delay 0 at the surface below each trace, by its recorded height.

    This changes the spectra, so no delay is rounded. The recorded delay of cables and antennas is
    removed too. Variable `advance` holds the delay that was removed, from which imaging computes
    the position of the antennas.

    Raises:
        WrongDatasetError: Time zero was set before.
        DamagedSurveyError: A usable sample has no height.
    """
    if ADVANCE in survey:
        raise WrongDatasetError(
            Message("time zero was set before; setting it again would shift it twice")
        )
    measured = require(survey, S21, S21_DIMS)
    advance = two_way_delay_s(known_height(survey)) + recorded_delay_s(survey)
    advance = advance.transpose(*SAMPLE_DIMS)
    turns = phase_advance(survey[FREQUENCY].values, advance.values)
    removed = advance.assign_attrs(units="s", long_name="delay that was removed: time zero")
    return survey.assign({S21: measured.copy(data=measured.values * turns), ADVANCE: removed})


def known_height(survey: xr.Dataset) -> xr.DataArray:
    """Return the heights (polarization, y, x) after a check that all usable samples have one.

    Raises:
        WrongDatasetError: The data have no heights.
        DamagedSurveyError: A usable sample has none.
    """
    height_m = require(survey, HEIGHT, SAMPLE_DIMS)
    lacking = (usable(survey) & ~(height_m > 0.0)).transpose(*SAMPLE_DIMS)
    if bool(lacking.any()):
        raise DamagedSurveyError(
            Message(
                "{count} usable samples have no height, the first at {position}; give one height "
                "for all samples (--height)",
                count=int(lacking.sum()),
                position=positions_of(survey, lacking.values)[0],
            ),
            fault=NOT_ALLOWED,
        )
    return height_m


def recorded_delay_s(survey: xr.Dataset) -> float:
    """Return the delay that the spectra contain as far as the survey knows [s]; 0 if unknown."""
    return _recorded(survey, ANTENNA_DELAY, LONGEST_DELAY_S)


def recorded_separation_m(survey: xr.Dataset) -> float:
    """Return the distance between the antennas as far as the survey knows [m]; 0 if unknown."""
    return _recorded(survey, ANTENNA_SEPARATION, WIDEST_SEPARATION_M)


def _recorded(survey: xr.Dataset, name: str, most: float) -> float:
    found = survey.attrs.get(name, 0.0)
    number = float(found) if isinstance(found, numbers.Real) else math.nan
    # Written so that NaN is refused too.
    if not abs(number) <= most:
        raise WrongDatasetError(
            Message(
                "attribute {name} of the survey is {found}; give data with at most {most:g}",
                name=name,
                found=str(found),
                most=most,
            ),
            fault=errors.INPUT,
        )
    return number


def delay_to_remove_s(survey: xr.Dataset, given_s: Optional[float]) -> float:
    """Return the delay that an image removes [s].

    Args:
        survey: The survey.
        given_s: The delay of the image's options [s]; None: the recorded one.

    Raises:
        WrongDatasetError: A delay was given, but a step has removed one.
    """
    if given_s is None:
        return recorded_delay_s(survey)
    if given_s and REMOVED in survey.attrs:
        raise WrongDatasetError(
            Message(
                "a step has removed {delay_ns:g} ns, so --delay would remove a second "
                "delay; use one of them",
                delay_ns=survey.attrs[REMOVED] * 1e9,
            ),
            fault=NOT_ALLOWED,
        )
    return given_s
