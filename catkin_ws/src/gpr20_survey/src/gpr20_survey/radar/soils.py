"""Soils an operator can choose, with the relative permittivity that the radar assumes for each.

The values lie within the ranges at 100 MHz of Davis and Annan, "Ground-penetrating radar for
high-resolution mapping of soil and rock stratigraphy", Geophysical Prospecting 37 (1989), table 1:
dry sand 3 to 5, saturated sand 20 to 30, clay 5 to 40. Between dry and saturated the equation of
Topp, Davis and Annan, "Electromagnetic determination of soil water content", Water Resources
Research 16 (1980), gives 5 for 9 %, 8 for 16 % and 12 for 23 % water by volume.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between

# Air, and water at 20 °C: no soil lies outside of these.
MIN_PERMITTIVITY, MAX_PERMITTIVITY = 1.0, 81.0
# What images accept: some more, since water has 88 near its freezing point.
LARGEST_PERMITTIVITY = 100.0


@dataclass(frozen=True)
class Soil:
    """A kind of ground, with its relative permittivity and the range that is usual."""

    name: Message
    permittivity: float
    lowest: float
    highest: float


class Soils(enum.Enum):
    """The soils to choose from, in the order of their permittivity but for clay, which is last."""

    DRY_SAND = Soil(Message("Dry sand"), 4.0, 3.0, 5.0)
    MOIST_SAND = Soil(Message("Moist sand"), 8.0, 5.0, 12.0)
    WET_SAND = Soil(Message("Wet sand"), 20.0, 12.0, 30.0)
    CLAY = Soil(Message("Clay"), 15.0, 5.0, 40.0)


ANY_SOIL = Soil(Message("Any soil"), 5.0, 2.0, 16.0)
"""What is assumed if nothing is known: the soils that surveys for mines have met."""


def soil_of(permittivity: float) -> Optional[Soils]:
    """Return the soil that has exactly this permittivity; None if it is the operator's own."""
    return next((one for one in Soils if one.value.permittivity == permittivity), None)


def requested_permittivity(value: float) -> Optional[float]:
    """Return the permittivity of a request; None: it is 0, not known.

    Raises:
        InvalidValueError: It is that of no ground.
    """
    name = "permittivity (0: not known)"
    return number_between(name, value, MIN_PERMITTIVITY, LARGEST_PERMITTIVITY) if value else None
