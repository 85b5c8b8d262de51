"""The transform from frequency to time, and the origin of time."""

from __future__ import annotations

import numpy as np
import scipy.fft
import xarray as xr

from gpr20_analysis import lazy
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
from gpr20_analysis.processing.antenna_delay import REMOVED, check_delay, recorded_delay_s
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans, even_delays_s
from gpr20_analysis.processing.to_frequency import SPECTRUM, Spectrum
from gpr20_analysis.read.survey_attributes import ANTENNA_DELAY
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.depth import two_way_delay_s
from gpr20_survey.radar.frequency_to_delay import Window, phase_advance

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
    measured = lazy.in_rows(require(survey, S21, S21_DIMS))
    sweep = FrequencyGrid.of(survey)
    count = scipy.fft.next_fast_len(int(np.ceil(padding * sweep.count)))
    found = xr.apply_ufunc(
        lambda spectra: a_scans(spectra, sweep, count, window),
        measured.drop_vars(FREQUENCY),
        input_core_dims=[[FREQUENCY]],
        output_core_dims=[[DELAY]],
        dask="parallelized",
        output_dtypes=[measured.dtype],
        dask_gufunc_kwargs={"output_sizes": {DELAY: count}},
    )
    in_time = survey.drop_vars(S21).drop_vars(FREQUENCY)
    in_time = in_time.assign_attrs({SPECTRUM: Spectrum(sweep, window).to_json()})
    in_time = in_time.assign_coords(
        {DELAY: (DELAY, even_delays_s(sweep, count), ATTRIBUTES[DELAY])}
    )
    return in_time.assign({A_SCAN: found.assign_attrs(ATTRIBUTES[A_SCAN])})


def remove_delay(survey: xr.Dataset, delay_s: float) -> xr.Dataset:
    """Remove the delay of cables and antennas from the spectra.

    Images of the result remove no further delay.

    Args:
        survey: Dataset with `s21`.
        delay_s: The delay [s], such as `gpr20 delay` fits it.

    Raises:
        WrongDatasetError: The delay is out of range or was removed before, or time zero was set.
    """
    check_delay(delay_s)
    measured = require(survey, S21, S21_DIMS)
    if REMOVED in survey.attrs:
        raise WrongDatasetError(
            Message(
                "the step delay removed {delay_ns:g} ns before; a second delay would add to it",
                delay_ns=survey.attrs[REMOVED] * 1e9,
            )
        )
    if ADVANCE in survey:
        raise WrongDatasetError(
            Message("time zero was set before; apply the step delay before time_zero")
        )
    turns = phase_advance(survey[FREQUENCY].values, np.asarray(delay_s))
    shifted = lazy.in_rows(measured) * xr.DataArray(turns, dims=FREQUENCY)
    attributes = {**survey.attrs, ANTENNA_DELAY: 0.0, REMOVED: delay_s}
    return survey.assign({S21: shifted.assign_attrs(measured.attrs)}).assign_attrs(attributes)


def set_time_zero(survey: xr.Dataset) -> xr.Dataset:
    """Put delay 0 at the surface below each trace, by its recorded height.

    This changes the spectra, so no delay is rounded. The recorded delay of cables and antennas is
    removed too. Variable `advance` holds the delay that was removed, from which imaging computes
    the position of the antennas.

    Raises:
        WrongDatasetError: Time zero was set before.
        DamagedSurveyError: A usable sample has no height.
    """
    require(survey, S21, S21_DIMS)
    if ADVANCE in survey:
        raise WrongDatasetError(
            Message("time zero was set before; setting it again would shift it twice")
        )
    return advanced(survey, two_way_delay_s(known_height(survey)) + recorded_delay_s(survey))


def advanced(survey: xr.Dataset, advance: xr.DataArray) -> xr.Dataset:
    """Return a survey without a delay of each trace, which becomes variable `advance`.

    Args:
        survey: Dataset with `s21`.
        advance: The delay (polarization, y, x) [s].
    """
    measured = lazy.in_rows(require(survey, S21, S21_DIMS))
    frequency_hz = survey[FREQUENCY].values
    shifted = xr.apply_ufunc(
        lambda s21, s: s21 * phase_advance(frequency_hz, s),
        measured,
        lazy.beside(advance, measured),
        input_core_dims=[[FREQUENCY], []],
        output_core_dims=[[FREQUENCY]],
        dask="parallelized",
        output_dtypes=[measured.dtype],
    )
    removed = advance.assign_attrs(units="s", long_name="delay that was removed: time zero")
    return survey.assign({S21: shifted, ADVANCE: removed})


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
                "for all samples (--height), or apply the step fill",
                count=int(lacking.sum()),
                position=positions_of(survey, lacking.values)[0],
            ),
            fault=NOT_ALLOWED,
        )
    return height_m
