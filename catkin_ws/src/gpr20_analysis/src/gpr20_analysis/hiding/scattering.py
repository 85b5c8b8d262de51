"""What a target in the ground sends back to an isotropic source in the air, by ray optics.

Everything is in the terms of `AntennaModel`: a mirror at a path of 1 m has magnitude 1. Waves go
down and up by refracted rays; the strength of a ray is that of its tube, times the transmission of
the surface by Fresnel. By reciprocity it is the same on both ways.

The face of a disc reflects as a layer of its thickness does, echoes within it and all, summed over
the face with the phase of each ray (Kirchhoff's approximation; see Balanis, Advanced Engineering
Electromagnetics, 2nd edition, sections 5.5 and 7.10). A metal ball sends back Mie's series (Bohren
and Huffman, Absorption and Scattering of Light by Small Particles, chapter 4, with the limits of a
perfect conductor), taken in the soil's wave number. So a disc should be at least half as wide as
the wavelength in the soil.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np
from scipy.special import spherical_jn, spherical_yn

from gpr20_survey.radar import SPEED_OF_LIGHT_M_S, tangent_in_air
from gpr20_survey.results.hiding_map import Target

STEP_M = 0.005
"""Of the distances of a table."""
PER_WAVELENGTH = 5.0
# Below, a ray is vertical.
SMALLEST_M = 1e-6


@dataclass(frozen=True)
class Soil:
    """The soil around a target.

    Attributes:
        permittivity: Relative permittivity.
        loss_tangent: Imaginary over real part of the permittivity, the same at all frequencies.
    """

    permittivity: float
    loss_tangent: float = 0.0

    @property
    def index(self) -> float:
        """The refractive index."""
        return float(np.sqrt(self.permittivity))


@dataclass(frozen=True)
class Echo:
    """What a target sends back, by its distance across from the antennas.

    Attributes:
        depth_m: Depth that its delays belong to [m].
        values: Spectra without the phase of that path (distance, frequency), of `STEP_M`.
    """

    depth_m: float
    values: np.ndarray


def echo_of(
    target: Target,
    top_m: float,
    soil: Soil,
    height_m: float,
    frequency_hz: np.ndarray,
    reach_m: float,
) -> Echo:
    """Return the echo of a target.

    Args:
        target: The target.
        top_m: Depth of its top [m].
        soil: The soil.
        height_m: Height of the antennas [m].
        frequency_hz: Frequencies [Hz].
        reach_m: Largest distance across [m].
    """
    distance_m = STEP_M * np.arange(int(np.ceil(reach_m / STEP_M)) + 2)
    wave = 2.0 * np.pi * frequency_hz / SPEED_OF_LIGHT_M_S
    if target.is_metal:
        depth_m = top_m + target.diameter_m / 2.0
        _, strength, length_m, _ = _rays(height_m, depth_m, distance_m, soil)
        sent = ball_amplitude_m(soil.index * wave, target.diameter_m / 2.0)
        return Echo(depth_m, strength[:, None] ** 2 * _decay(soil, wave, length_m) * sent)
    path_m, _, _, _ = _rays(height_m, top_m, distance_m, soil)
    reflected = layer_reflection(target, soil, wave)
    spacing_m = SPEED_OF_LIGHT_M_S / (frequency_hz[-1] * soil.index * PER_WAVELENGTH)
    along_m, aside_m, area_m2 = _face(target.diameter_m / 2.0, spacing_m)
    values = np.empty((len(distance_m), len(frequency_hz)), complex)
    for row, away_m in enumerate(distance_m):
        point_m, strength, length_m, cosine = _rays(
            height_m, top_m, np.hypot(along_m - away_m, aside_m), soil
        )
        factor = cosine * strength**2 * area_m2
        turn = np.exp(-2j * np.outer(point_m - path_m[row], wave)) * _decay(soil, wave, length_m)
        values[row] = factor @ turn
    return Echo(top_m, values * reflected * 1j * soil.index * wave / (2.0 * np.pi))


def layer_reflection(target: Target, soil: Soil, wave: np.ndarray) -> np.ndarray:
    """Return the reflection of a layer as thick as a disc, at right angles (frequency,).

    Args:
        target: A disc.
        soil: The soil on both sides.
        wave: Wave numbers in air [rad/m].
    """
    index = float(np.sqrt(target.permittivity or 1.0))
    face = (soil.index - index) / (soil.index + index)
    through = np.exp(-2j * wave * index * target.height_m)
    found: np.ndarray = face * (1.0 - through) / (1.0 - face**2 * through)
    return found


def ball_amplitude_m(wave: np.ndarray, radius_m: float) -> np.ndarray:
    """Return what a conducting ball sends back, at 1 m, by the wave numbers around it [m].

    Of a large ball that is half its radius, negative, from its nearest point.
    """
    size = wave * radius_m
    found = np.zeros(len(wave), complex)
    for order in range(1, int(size.max() + 4.0 * size.max() ** (1.0 / 3.0)) + 3):
        bessel, neumann = spherical_jn(order, size), spherical_yn(order, size)
        hankel = bessel + 1j * neumann
        bessel_change = spherical_jn(order, size, derivative=True)
        hankel_change = bessel_change + 1j * spherical_yn(order, size, derivative=True)
        electric = (bessel + size * bessel_change) / (hankel + size * hankel_change)
        found += (-1.0) ** order * (2 * order + 1) * (electric - bessel / hankel)
    # Their time runs the other way.
    back: np.ndarray = (found / (2j * wave)).conj()
    return back


def _face(radius_m: float, spacing_m: float) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points of half a disc, along and aside [m], and twice the area of each [m2]."""
    rings = max(2, int(np.ceil(radius_m / spacing_m)))
    along, aside, area = [], [], []
    for ring in range(rings):
        middle_m, wide_m = (ring + 0.5) * radius_m / rings, radius_m / rings
        count = max(3, int(np.ceil(np.pi * middle_m / spacing_m)))
        turn = (np.arange(count) + 0.5) * np.pi / count
        along.append(middle_m * np.cos(turn))
        aside.append(middle_m * np.sin(turn))
        area.append(np.full(count, 2.0 * np.pi * middle_m * wide_m / count))
    return np.concatenate(along), np.concatenate(aside), np.concatenate(area)


def _rays(
    height_m: float, depth_m: float, distance_m: np.ndarray, soil: Soil
) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return optical path [m], strength [1/m], way in the soil [m] and its cosine, of each ray."""
    across_m = np.maximum(distance_m, SMALLEST_M)
    tangent = tangent_in_air(np.asarray(height_m), np.asarray(depth_m), across_m, soil.permittivity)
    secant = np.sqrt(1.0 + tangent**2)
    air = 1.0 / secant
    ground = np.sqrt(1.0 - (tangent / secant / soil.index) ** 2)
    length_m = depth_m / ground
    path_m = height_m * secant + soil.index * length_m
    spread_m = height_m * secant**2 + depth_m * air / (soil.index * ground**3)
    tube = np.sqrt(tangent / (across_m * spread_m))
    across = 2.0 * air / (air + soil.index * ground)
    within = 2.0 * air / (soil.index * air + ground)
    # A dipole sends by the cosine along itself, and alike across: one and the other way, that much.
    return path_m, 0.5 * (across + within) * tube * np.sqrt(air), length_m, ground


def _decay(soil: Soil, wave: np.ndarray, length_m: np.ndarray) -> np.ndarray:
    """Return what is left after the way down and up (ray, frequency)."""
    left: np.ndarray = np.exp(-np.outer(length_m, soil.index * soil.loss_tangent * wave))
    return left
