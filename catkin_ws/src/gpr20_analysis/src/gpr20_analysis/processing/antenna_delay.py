"""What is known of the delay of cables and antennas in the spectra, and of their separation."""

from __future__ import annotations

import math
from typing import Optional

import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.read.survey_attributes import (
    ANTENNA_DELAY,
    ANTENNA_SEPARATION,
    WIDEST_SEPARATION_M,
)
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message

REMOVED = "antenna_delay_removed_s"
"""Attribute: the delay that the step `delay` removed from the spectra [s]."""
LONGEST_DELAY_S = 1e-5
"""The record of an impulse radar may begin microseconds before its pulse [s]."""


def recorded_delay_s(survey: xr.Dataset) -> float:
    """Return the delay that the spectra contain as far as the survey knows [s]; 0 if unknown."""
    try:
        delay_s = float(survey.attrs.get(ANTENNA_DELAY, 0.0))
    except (TypeError, ValueError):
        delay_s = math.nan
    check_delay(delay_s)
    return delay_s


def recorded_separation_m(survey: xr.Dataset) -> float:
    """Return the distance between the antennas as far as the survey knows [m]; 0 if unknown.

    Raises:
        WrongDatasetError: It is no such distance.
    """
    found = survey.attrs.get(ANTENNA_SEPARATION, 0.0)
    # Written so that NaN is refused too.
    if not (isinstance(found, (int, float)) and 0.0 <= found <= WIDEST_SEPARATION_M):
        raise WrongDatasetError(
            Message(
                "the survey says that its antennas are {found} m apart; give data with 0 to "
                "{most:g} m",
                found=str(found),
                most=WIDEST_SEPARATION_M,
            ),
            fault=faults.INPUT,
        )
    return float(found)


def delay_to_remove_s(survey: xr.Dataset, given_s: Optional[float]) -> float:
    """Return the delay that an image removes [s].

    Args:
        survey: The survey.
        given_s: The delay of the image's options [s]; None: the recorded one.

    Raises:
        WrongDatasetError: A delay was given, but the step `delay` has removed one.
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


def check_delay(delay_s: float) -> None:
    """Check the range of a delay.

    Raises:
        WrongDatasetError: It is NaN or outside the range.
    """
    # Written so that NaN is refused too.
    if not -LONGEST_DELAY_S <= delay_s <= LONGEST_DELAY_S:
        raise WrongDatasetError(
            Message(
                "the delay of cables and antennas is {delay_ns:g} ns; it must lie between "
                "{lower_ns:g} and {upper_ns:g} ns",
                delay_ns=delay_s * 1e9,
                lower_ns=-LONGEST_DELAY_S * 1e9,
                upper_ns=LONGEST_DELAY_S * 1e9,
            ),
            fault=NOT_ALLOWED,
        )
