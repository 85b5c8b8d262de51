"""Targets in the spectra of a survey, as if they had been in its ground."""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import HEIGHT, POLARIZATION, S21, S21_DIMS, SAMPLE_DIMS, X, Y
from gpr20_analysis.hiding.scattering import STEP_M, Echo
from gpr20_analysis.imaging.phase_shift import unit_phasor
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_survey.radar.refraction import one_way_delay_s

# Of the median magnitude of all traces: in fainter ones, the antennas received nothing.
DEAD_SHARE = 0.1


def with_targets(
    survey: xr.Dataset,
    echo: Echo,
    places_m: Sequence[Tuple[float, float]],
    permittivity: float,
    transmission: np.ndarray,
    separation_m: float,
) -> xr.Dataset:
    """Return a survey with the echoes of targets added to its spectra, but not to dead traces.

    Args:
        survey: The survey as measured, in memory.
        echo: What each target sends back.
        places_m: X and Y of each target [m].
        permittivity: Relative permittivity of the soil.
        transmission: Of the antennas (polarization, frequency) [m].
        separation_m: Distance between the antennas, along their rotation [m].
    """
    sweep = FrequencyGrid.of(survey)
    spectra = survey[S21].transpose(*S21_DIMS).values.astype(np.complex128)
    height_m = survey[HEIGHT].transpose(*SAMPLE_DIMS).values
    x_m, y_m = np.meshgrid(survey[X].values, survey[Y].values)
    turns_rad = np.radians(np.nan_to_num(survey[POLARIZATION].values.astype(np.float64)))
    for turn, rotation_rad in enumerate(turns_rad):
        half_m = 0.5 * separation_m * np.array([np.cos(rotation_rad), np.sin(rotation_rad)])
        at = np.flatnonzero(np.isfinite(height_m[turn]).ravel() & _alive(spectra[turn]).ravel())
        added = np.zeros((at.size, sweep.count), np.complex64)
        for target_m in places_m:
            away = np.stack([x_m.ravel()[at] - target_m[0], y_m.ravel()[at] - target_m[1]])
            delay_s = sum(
                one_way_delay_s(
                    height_m[turn].ravel()[at],
                    echo.depth_m,
                    np.hypot(*(away + side * half_m[:, None])),
                    permittivity,
                )
                for side in (-1.0, 1.0)
            )
            added += _levels(echo, np.hypot(*away)) * _phasors(np.asarray(delay_s), sweep)
        spectra[turn].reshape(-1, sweep.count)[at] += added * transmission[turn]
    return survey.assign({S21: (S21_DIMS, spectra, survey[S21].attrs)})


def _alive(spectra: np.ndarray) -> np.ndarray:
    """Return which traces (y, x) have received about as much as the others, so not only noise."""
    level = np.sqrt(np.mean(np.abs(np.nan_to_num(spectra)) ** 2, axis=-1))
    alive: np.ndarray = level > DEAD_SHARE * np.median(level[level > 0.0]) if level.any() else level
    return alive


def _levels(echo: Echo, distance_m: np.ndarray) -> np.ndarray:
    """Return the spectra of a table at distances, without the phase of their path."""
    place = np.minimum(distance_m / STEP_M, len(echo.values) - 1.001)
    low = place.astype(int)
    share = (place - low).astype(np.float32)[:, None]
    values = echo.values.astype(np.complex64)
    found: np.ndarray = values[low] * (1.0 - share) + values[low + 1] * share
    return found


def _phasors(delay_s: np.ndarray, sweep: FrequencyGrid) -> np.ndarray:
    """Return exp(-2j pi f t) (trace, frequency), as the product of two much smaller tables."""
    block = int(np.ceil(np.sqrt(sweep.count)))
    firsts = sweep.start_hz + sweep.step_hz * block * np.arange(-(-sweep.count // block))
    turn = -2.0 * np.pi * delay_s[:, None]
    coarse = unit_phasor(turn * firsts)
    fine = unit_phasor(turn * (sweep.step_hz * np.arange(block)))
    product = coarse[:, :, None] * fine[:, None, :]
    phasors: np.ndarray = product.reshape(len(delay_s), -1)[:, : sweep.count]
    return phasors
