"""Spectra over horizontal wavenumber at one height, of traces that have different heights."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np
import scipy.fft
from numpy.polynomial.chebyshev import chebpts1

from gpr20_analysis.imaging.records import Focus

THREADS = 2
# Of the amplitude of a wave of the highest frequency at the widest angle; all others are nearer.
TOLERANCE = 0.03
# Samples whose phases are computed at once.
SAMPLES_AT_ONCE = 250_000


def transform_at_one_height(
    spectra: np.ndarray,
    higher_m: np.ndarray,
    padded: Tuple[int, int],
    air_rad_m: np.ndarray,
    across_rad_m: np.ndarray,
    focus: Focus,
) -> np.ndarray:
    """Return the spectra over wavenumber (frequency, wavenumber) at the middle height.

    Waves beyond the widest angle may be 0.

    Each plane wave of each trace gets the phase of its way from the height of the trace to the
    middle height: exp(i kz d), with kz the vertical wavenumber. Over the heights d of the traces
    that is interpolated by a polynomial through its values at Chebyshev points. Before that, the
    phase at the middle of all kz is taken out, because it is the same for all wavenumbers.

    Args:
        spectra: Spectra of the traces (frequency, y, x); may be overwritten.
        higher_m: How much higher than the middle each trace is (y, x) [m].
        padded: Size of the transform along Y and X.
        air_rad_m: Two-way wavenumber in air of each frequency [rad/m].
        across_rad_m: Horizontal wavenumber over the flat transform [rad/m].
        focus: How to focus.
    """
    cosine = math.cos(math.radians(focus.widest_angle_deg))
    most_m = float(np.max(np.abs(higher_m)))
    count = points_needed(most_m * float(air_rad_m[-1]) * (1.0 - cosine) / 2.0)
    middle_rad_m = air_rad_m * (1.0 + cosine) / 2.0 if count > 1 else air_rad_m
    if most_m > 0.0:
        spectra *= unit_phasor(middle_rad_m[:, None, None] * higher_m)
    if count == 1:
        return _transform(spectra, padded)
    points_m = most_m * chebpts1(count)
    weights = _lagrange_weights(points_m, higher_m)
    found = np.zeros((len(spectra), len(across_rad_m)), dtype=np.complex64)
    widest = math.sin(math.radians(focus.widest_angle_deg))
    at_once = max(1, SAMPLES_AT_ONCE // len(across_rad_m))
    for start in range(0, len(spectra), at_once):
        part = slice(start, start + at_once)
        used = np.flatnonzero(across_rad_m < air_rad_m[part][-1] * widest)
        square = air_rad_m[part, None] ** 2 - across_rad_m[used] ** 2
        down = np.sqrt(np.maximum(square, 0.0)) - middle_rad_m[part, None]
        moved = np.zeros(down.shape, dtype=np.complex64)
        turns = [unit_phasor(down * point_m) for point_m in points_m[: count // 2]]
        # The points are symmetric, and one in the middle has no phase.
        middle = [np.ones((1, 1), dtype=np.complex64)] * (count % 2)
        turns = [*turns, *middle, *(turn.conj() for turn in reversed(turns))]
        for weight, turn in zip(weights, turns):
            moved += _transform(spectra[part] * weight, padded)[:, used] * turn
        found[part, used] = moved
    return found


def points_needed(most_rad: float) -> int:
    """Return how many points interpolate exp(i phase) for phases up to +- most, to the tolerance.

    The error of Chebyshev interpolation of degree n - 1 is at most most^n / (2^(n-1) n!).
    """
    count, error = 1, most_rad
    while error > TOLERANCE:
        count += 1
        error *= most_rad / (2.0 * count)
    return count


def _lagrange_weights(points: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the weight of each point in the interpolation at each place (point, ...)."""
    weights = np.ones((len(points), *places.shape), dtype=np.float32)
    for index, point in enumerate(points):
        for other in np.delete(points, index):
            weights[index] *= (places - other) / (point - other)
    return weights


def _transform(spectra: np.ndarray, padded: Tuple[int, int]) -> np.ndarray:
    flat: np.ndarray = scipy.fft.fft2(spectra, s=padded, workers=THREADS)
    return flat.reshape(len(spectra), -1)


def unit_phasor(phase_rad: np.ndarray) -> np.ndarray:
    """Return exp(1j phase) in single precision, the phase taken modulo a turn in double."""
    small = np.remainder(phase_rad, 2.0 * np.pi).astype(np.float32)
    phasor = np.empty(small.shape, dtype=np.complex64)
    np.cos(small, out=phasor.real)
    np.sin(small, out=phasor.imag)
    return phasor
