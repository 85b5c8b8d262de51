"""The hyperbola of a small target in a line, and the permittivity that fits one that is seen.

The wave runs through air to the surface, is refracted there, and returns on the same path. The
target and the antennas lie in the plane of the line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gpr20_user_interface.mid.radar_processing import SPEED_OF_LIGHT_M_S, deepest_m
from gpr20_user_interface.mid.soils import MAX_PERMITTIVITY, MIN_PERMITTIVITY

# Halvings of an interval: more than single precision needs.
HALVINGS = 40
# The apex lies at least so far below the surface: closer to it the shape says nothing.
SHALLOWEST_M = 0.005


@dataclass(frozen=True)
class Hyperbola:
    """The echoes of a target below a line.

    Args:
        across_mm: Where the target is along the line [mm].
        apex_delay_s: Two-way delay straight above it [s].
        height_m: Height of the antennas above the surface [m].
        permittivity: Relative permittivity of the ground.
    """

    across_mm: float
    apex_delay_s: float
    height_m: float
    permittivity: float

    @property
    def depth_m(self) -> float:
        """Depth of the target [m]."""
        depth_m = deepest_m(self.apex_delay_s, self.height_m, self.permittivity)
        return max(depth_m, SHALLOWEST_M / math.sqrt(self.permittivity))

    def delays_s(self, across_mm: np.ndarray) -> np.ndarray:
        """Return the delays at places along the line [s]."""
        offsets_m = np.abs(np.asarray(across_mm) - self.across_mm) * 1e-3
        return echo_delays_s(offsets_m, self.depth_m, self.height_m, self.permittivity)

    def through(self, across_mm: float, delay_s: float) -> Hyperbola:
        """Return the hyperbola with the same apex that passes as close to a point as possible."""
        low, high = MIN_PERMITTIVITY, MAX_PERMITTIVITY
        place = np.array([across_mm])
        for _ in range(HALVINGS):
            middle = math.sqrt(low * high)
            # The slower the wave, the steeper the hyperbola.
            if float(self._with(middle).delays_s(place)[0]) < delay_s:
                low = middle
            else:
                high = middle
        return self._with(math.sqrt(low * high))

    def _with(self, permittivity: float) -> Hyperbola:
        return Hyperbola(self.across_mm, self.apex_delay_s, self.height_m, permittivity)


def echo_delays_s(
    offsets_m: np.ndarray, depth_m: float, height_m: float, permittivity: float
) -> np.ndarray:
    """Return the two-way delays of a target [s].

    Args:
        offsets_m: Horizontal distances between antennas and target [m].
        depth_m: Depth of the target below the surface [m].
        height_m: Height of the antennas above the surface [m].
        permittivity: Relative permittivity of the ground.
    """
    offsets_m = np.abs(np.asarray(offsets_m, np.float64))
    index = math.sqrt(permittivity)
    # The refracted ray crosses the surface where the sines of Snell's law agree.
    low, high = np.zeros_like(offsets_m), offsets_m.copy()
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        rest = offsets_m - middle
        too_near = middle / np.hypot(height_m, middle) < index * rest / np.hypot(depth_m, rest)
        low, high = np.where(too_near, middle, low), np.where(too_near, high, middle)
    crossing = (low + high) / 2.0
    path_m = np.hypot(height_m, crossing) + index * np.hypot(depth_m, offsets_m - crossing)
    return 2.0 / SPEED_OF_LIGHT_M_S * path_m
