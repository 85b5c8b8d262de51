"""Places of a survey's area on the earth."""

from __future__ import annotations

import math
from typing import Any, Mapping, Optional, Tuple

from gpr20_analysis.candidates.candidate import AreaPosition
from gpr20_analysis.read.annotation_attributes import HEADING, LATITUDE, LONGITUDE

SEMI_MAJOR_AXIS_M = 6378137.0
ECCENTRICITY_2 = 0.00669437999014
"""WGS 84: equatorial radius, and square of the first eccentricity."""


def area_position(attributes: Mapping[str, Any]) -> Optional[AreaPosition]:
    """Return where the area of a survey is on the earth; None if that is not known."""
    names = (LATITUDE, LONGITUDE, HEADING)
    if not all(name in attributes for name in names):
        return None
    return AreaPosition(*(float(attributes[name]) for name in names))


def on_earth(position: AreaPosition, x_m: float, y_m: float) -> Tuple[float, float]:
    """Return WGS 84 longitude and latitude [deg] of a place of the area.

    The surface is taken as a plane, which is right within a millimetre over 10 m.
    """
    heading = math.radians(position.heading_deg)
    north_m = y_m * math.cos(heading) - x_m * math.sin(heading)
    east_m = y_m * math.sin(heading) + x_m * math.cos(heading)
    latitude = math.radians(position.latitude_deg)
    bulge = 1.0 - ECCENTRICITY_2 * math.sin(latitude) ** 2
    along_meridian_m = SEMI_MAJOR_AXIS_M * (1.0 - ECCENTRICITY_2) / bulge**1.5
    across_m = max(SEMI_MAJOR_AXIS_M / math.sqrt(bulge) * math.cos(latitude), 1.0)
    longitude_deg = position.longitude_deg + math.degrees(east_m / across_m)
    return (
        (longitude_deg + 180.0) % 360.0 - 180.0,
        position.latitude_deg + math.degrees(north_m / along_meridian_m),
    )
