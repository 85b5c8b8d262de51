"""The field of a horizontal dipole over a half space, exact, as an integral over plane waves.

A horizontal electric dipole at a height over the ground is a sum of plane waves; each is refracted
by Fresnel's coefficients, TE and TM apart, and the sum over their azimuths gives Bessel functions.
See Chew, Waves and Fields in Inhomogeneous Media (1995), sections 2.2 and 2.3, and Michalski and
Mosig, Multilayered media Green's functions in integral equation formulations, IEEE Trans. Antennas
Propag. 45 (1997), 508-519. Near, evanescent and lateral waves are all in it.

Fields are those of a dipole of 1 A m, with exp(-2j pi f t) for a delay t.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np
from scipy.constants import epsilon_0, mu_0, speed_of_light
from scipy.special import j0, j1

# Waves that decay more on their way through the air are left out, in nepers.
MOST_DECAY = 20.0


@dataclass(frozen=True)
class Soil:
    """A half space.

    Attributes:
        permittivity: Relative permittivity.
        conductivity_s_per_m: Conductivity [S/m].
    """

    permittivity: float
    conductivity_s_per_m: float = 0.0

    def at(self, frequency_hz: float) -> complex:
        """Return the complex relative permittivity."""
        loss = self.conductivity_s_per_m / (2.0 * np.pi * frequency_hz * epsilon_0)
        return complex(self.permittivity, -loss)


def waves(
    frequency_hz: float, soil: complex, air_m: float, reach_m: float
) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return wavenumbers across, their weights times themselves, and those down in air and soil.

    The path stays on the real axis: between the branch points k**2 = a**2 + (b**2 - a**2)
    sin(t)**2 makes the integrand smooth, and Gauss's nodes in t converge fast.

    Args:
        frequency_hz: The frequency [Hz].
        soil: Complex relative permittivity of the soil.
        air_m: Shortest way through the air [m].
        reach_m: Longest way [m].
    """
    air = 2.0 * np.pi * frequency_hz / speed_of_light
    last = float(np.hypot(air, MOST_DECAY / air_m))
    edges = (0.0, air, min(max(air, air * np.sqrt(soil).real), last), last)
    square, weight = [], []
    for start, end in zip(edges[:-1], edges[1:]):
        if end - start > 1e-9 * air:
            nodes, parts = np.polynomial.legendre.leggauss(40 + int(0.8 * (end - start) * reach_m))
            turn = (nodes + 1.0) * np.pi / 4.0
            square.append(start**2 + (end**2 - start**2) * np.sin(turn) ** 2)
            weight.append(parts * np.pi / 8.0 * (end**2 - start**2) * np.sin(2.0 * turn))
    squares = np.concatenate(square)
    above, below = (_downward(one * air**2 - squares) for one in (1.0, soil))
    return np.sqrt(squares), np.concatenate(weight), above, below


def transmitted(
    frequency_hz: float, soil: complex, height_m: float, depth_m: np.ndarray, distance_m: np.ndarray
) -> np.ndarray:
    """Return the three parts of the field in the ground (part, depth, distance) [V/m].

    At the azimuth a from the dipole's axis the field is part 0 + part 2 cos(2a) along the axis,
    part 2 sin(2a) across it and part 1 cos(a) downward.
    """
    reach_m = float(distance_m.max() + depth_m.max()) + height_m
    across, weight, above, below = waves(frequency_hz, soil, height_m, reach_m)
    air = 2.0 * np.pi * frequency_hz / speed_of_light
    electric = 2.0 / (above + below)
    magnetic = 2.0 * above / (air**2 * (below + soil * above))
    phase = weight * np.exp(-1j * (above * height_m + depth_m[:, None] * below))
    zeroth, first, second = _bessel(across[:, None] * distance_m)
    parts = (
        (phase * (electric + magnetic * below) / 2.0, zeroth),
        (1j * phase * magnetic * across, first),
        (phase * (electric - magnetic * below) / 2.0, second),
    )
    gain = -frequency_hz * mu_0 / 2.0
    return gain * np.stack([one.real @ order + 1j * (one.imag @ order) for one, order in parts])


def surface_echo(frequency_hz: float, soil: complex, height_m: float, apart_m: float) -> complex:
    """Return the field along dipoles beside each other that the surface reflects [V/m]."""
    across, weight, above, below = waves(frequency_hz, soil, 2.0 * height_m, apart_m + height_m)
    air = 2.0 * np.pi * frequency_hz / speed_of_light
    electric = (above - below) / (above + below) / above
    magnetic = (below - soil * above) / (below + soil * above) * above / air**2
    zeroth, _, second = _bessel(across * apart_m)
    values = (electric + magnetic) * zeroth - (electric - magnetic) * second
    phase = weight * np.exp(-2j * above * height_m)
    return complex(-frequency_hz * mu_0 / 4.0 * np.sum(phase * values))


def coupling(frequency_hz: float, apart_m: float) -> complex:
    """Return the field of a dipole in air along one beside it, near field and all [V/m]."""
    path = 2.0 * np.pi * frequency_hz / speed_of_light * apart_m
    near = 1.0 + 1.0 / (1j * path) - 1.0 / path**2
    return complex(-0.5j * frequency_hz * mu_0 / apart_m * near * np.exp(-1j * path))


def _downward(square: np.ndarray) -> np.ndarray:
    """Return the wavenumbers of waves that go down or decay, from their squares."""
    down = np.sqrt(square + 0j)
    return np.where(down.imag > 0.0, -down, down)


def _bessel(argument: np.ndarray) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return Bessel's functions of the orders 0, 1 and 2."""
    zeroth, first = j0(argument), j1(argument)
    large = np.maximum(argument, 1e-3)
    return zeroth, first, np.where(argument < 1e-3, argument**2 / 8.0, 2.0 / large * first - zeroth)
