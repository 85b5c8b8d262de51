"""Where a survey's area is on the earth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

from gpr20_common.mid.codec import bounded

SEMI_MAJOR_AXIS_M = 6378137.0
ECCENTRICITY_2 = 0.00669437999014
"""WGS 84: equatorial radius, and square of the first eccentricity."""


@dataclass(frozen=True)
class AreaPosition:
    """WGS 84 position of the origin of X and Y, north and east positive.

    The heading is the direction of +Y, clockwise from north; +X is 90 degrees to its right.
    """

    latitude_deg: float = bounded(-90.0, 90.0)
    longitude_deg: float = bounded(-180.0, 180.0)
    heading_deg: float = bounded(-math.inf, math.inf)

    def on_earth(self, x_m: float, y_m: float) -> Tuple[float, float]:
        """Return WGS 84 longitude and latitude [deg] of a place of the area.

        The surface is taken as a plane, which is right within a millimetre over 10 m.
        """
        heading = math.radians(self.heading_deg)
        north_m = y_m * math.cos(heading) - x_m * math.sin(heading)
        east_m = y_m * math.sin(heading) + x_m * math.cos(heading)
        latitude = math.radians(self.latitude_deg)
        bulge = 1.0 - ECCENTRICITY_2 * math.sin(latitude) ** 2
        along_meridian_m = SEMI_MAJOR_AXIS_M * (1.0 - ECCENTRICITY_2) / bulge**1.5
        across_m = max(SEMI_MAJOR_AXIS_M / math.sqrt(bulge) * math.cos(latitude), 1.0)
        longitude_deg = self.longitude_deg + math.degrees(east_m / across_m)
        return (
            (longitude_deg + 180.0) % 360.0 - 180.0,
            self.latitude_deg + math.degrees(north_m / along_meridian_m),
        )
