"""Targets in the spectra of a survey, as if they had been in its ground.

The transmission of the antennas is that of their model, or of the survey's own surface echo.
"""

from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import (
    ANTENNA,
    ANTENNA_DIMS,
    HEIGHT,
    MM_PER_M,
    POLARIZATION,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    X,
    Y,
    usable,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.hiding.scattering import STEP_M, Echo
from gpr20_analysis.imaging.phase_shift import unit_phasor
from gpr20_analysis.processing.delay import known_height, recorded_delay_s
from gpr20_analysis.processing.surface_echo import fit_delay
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import SPEED_OF_LIGHT_M_S, one_way_delay_s

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


# Of the terms of a model.
TRANSMISSION = 1
# An echo there is the surface, if it is that much above the median.
SURFACE_WITHIN_S, CLEAR = 0.3e-9, 6.0
# What the fit leaves of the coupling may be stronger.
OF_STRONGEST = 0.5
PADDING = 8
# Of the way through the air: how long what belongs to an echo lasts, before and after it.
LASTS = 0.375
# Of the resolution: the distance of the echoes that a spectrum is fitted with.
TAPS = 0.6
# The way through the air is at least so many resolutions long.
LEAST_RESOLUTIONS = 2.5
SMALLEST_SHARE = 1e-3


def of_model(model: xr.Dataset) -> np.ndarray:
    """Return the transmission of a model of the antennas (polarization, frequency) [m]."""
    values: np.ndarray = model[ANTENNA].transpose(*ANTENNA_DIMS).values[:, TRANSMISSION]
    return values


def of_surface(
    survey: xr.Dataset, separation_m: float, permittivities: Sequence[float]
) -> List[np.ndarray]:
    """Return the transmission by the echo of a survey's surface, for each permittivity [m].

    The traces are turned so that their surface echoes lie at one delay, and averaged. Coupling and
    surface are separated by their delay. Level soil reflects as Fresnel says; a rough surface
    reflects less, so the transmission comes out smaller and targets fainter than they are.

    Raises:
        WrongDatasetError: The echo of the surface is not clear.
    """
    sweep = FrequencyGrid.of(survey)
    known = usable(survey).transpose(*SAMPLE_DIMS).values
    path_m = np.hypot(2.0 * known_height(survey).values, separation_m)
    turn = 2j * np.pi * sweep.frequency_hz
    unclear: Optional[WrongDatasetError] = None
    try:
        delay_s = fit_delay(survey, separation_m).delay_s
    except WrongDatasetError as error:
        # A strong coupling hides the surface from that, but not where the heights say it is.
        delay_s, unclear = recorded_delay_s(survey), error
    echoes = []
    for spectra, own_m, present in zip(survey[S21].transpose(*S21_DIMS).values, path_m, known):
        present = present & np.isfinite(spectra).all(axis=-1)
        paths_m = own_m[present][:, None]
        back = np.exp(turn * (paths_m / SPEED_OF_LIGHT_M_S + delay_s)) * paths_m
        mean = np.mean(spectra[present] * back, axis=0)
        air_s = float(paths_m.mean()) / SPEED_OF_LIGHT_M_S
        _check_separate(air_s, sweep)
        echo, rest = _surface(mean, air_s, sweep)
        if unclear is not None and not _is_clear(rest, sweep):
            raise unclear
        echoes.append(echo * np.exp(-turn * delay_s))
    indices = np.sqrt(permittivities)
    return [np.stack(echoes) * (1.0 + index) / (1.0 - index) for index in indices]


def _check_separate(air_s: float, sweep: FrequencyGrid) -> None:
    """Check that the band separates the surface from the coupling.

    Raises:
        WrongDatasetError: It does not, so that a part of the coupling would count as surface, and
            targets would seem brighter than they are.
    """
    least_s = LEAST_RESOLUTIONS / (sweep.step_hz * sweep.count)
    # Written so that NaN is refused too.
    if not air_s >= least_s:
        raise WrongDatasetError(
            Message(
                "the antennas are {height_mm:.0f} mm above the surface; below {least_mm:.0f} mm "
                "this band does not separate its echo from the coupling, so give --antenna",
                height_mm=MM_PER_M * 0.5 * air_s * SPEED_OF_LIGHT_M_S,
                least_mm=MM_PER_M * 0.5 * least_s * SPEED_OF_LIGHT_M_S,
            ),
            fault=NOT_ALLOWED,
        )


def _surface(mean: np.ndarray, air_s: float, sweep: FrequencyGrid) -> Tuple[np.ndarray, np.ndarray]:
    """Return what is near delay 0 in a spectrum, and all of it, without the coupling before it.

    Surface and coupling, which is earlier by `air_s`, are fitted by least squares as sums of echoes
    near their delays.
    """
    apart_s = TAPS / (sweep.step_hz * sweep.count)
    count = int(LASTS * air_s / apart_s)
    near_s = apart_s * np.arange(-count, count + 1)
    delays_s = np.concatenate([near_s, near_s - air_s])
    columns = np.exp(-2j * np.pi * np.outer(sweep.frequency_hz, delays_s))
    found = np.linalg.lstsq(columns, mean, rcond=SMALLEST_SHARE)[0]
    surface, coupling = (
        columns[:, part] @ found[part] for part in (slice(len(near_s)), slice(len(near_s), None))
    )
    return surface, mean - coupling


def _is_clear(rest: np.ndarray, sweep: FrequencyGrid) -> bool:
    """Return whether a spectrum without coupling has an echo near delay 0."""
    level = np.abs(a_scans(rest, sweep, PADDING * sweep.count))
    delay_s = np.fft.fftfreq(len(level)) * sweep.unambiguous_s
    surface = level[np.abs(delay_s) < SURFACE_WITHIN_S].max()
    return bool(surface > CLEAR * np.median(level) and surface > OF_STRONGEST * level.max())
