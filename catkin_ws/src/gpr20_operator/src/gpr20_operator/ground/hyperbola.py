"""The hyperbola of a small target in a line, and the permittivity that fits one that is seen.

The wave runs through air to the surface, is refracted there, and returns on the same path. The
target and the antennas lie in the plane of the line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gpr20_survey.radar.depth import depth_of_delay_m
from gpr20_survey.radar.refraction import one_way_delay_s
from gpr20_survey.radar.soils import MAX_PERMITTIVITY, MIN_PERMITTIVITY

# Halvings of an interval: more than single precision needs.
HALVINGS = 40
# The apex lies at least so far below the surface: closer to it the shape says nothing.
SHALLOWEST_M = 0.005
# A sensor may answer 0.
LOWEST_M = 1e-6


@dataclass(frozen=True)
class Hyperbola:
    """The echoes of a target below a line.

    Attributes:
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
        depth_m = depth_of_delay_m(self.apex_delay_s, self.height_m, self.permittivity)
        return max(depth_m, SHALLOWEST_M / math.sqrt(self.permittivity))

    def delays_s(self, across_mm: np.ndarray) -> np.ndarray:
        """Return the delays at places along the line [s]."""
        offsets_m = np.abs(np.asarray(across_mm) - self.across_mm) * 1e-3
        height_m = max(self.height_m, LOWEST_M)
        return 2.0 * one_way_delay_s(height_m, self.depth_m, offsets_m, self.permittivity)

    def through(self, across_mm: float, delay_s: float) -> Hyperbola:
        """Return the hyperbola with the same apex that passes as close to a point as possible."""
        low, high = MIN_PERMITTIVITY, MAX_PERMITTIVITY
        place = np.array([across_mm])
        for _ in range(HALVINGS):
            middle = math.sqrt(low * high)
            # The slower the wave, the steeper the hyperbola.
            if float(replace(self, permittivity=middle).delays_s(place)[0]) < delay_s:
                low = middle
            else:
                high = middle
        return replace(self, permittivity=math.sqrt(low * high))
