"""The permittivity of an image, how it is known, and what depths are worth by it."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Dict, Tuple

import numpy as np
import xarray as xr

from gpr20_common.message import Message
from gpr20_survey.folder.soil_note import ENTERED, OF_PLAN
from gpr20_survey.radar.soils import Soil

GIVEN_UNCERTAINTY = 0.1
"""What a value that a person gave may be off, as a share of it: a good probe, at another place."""


class Source(enum.Enum):
    """Where a permittivity is from, the most reliable first; the value is for files."""

    SURFACE = "measured at the surface"
    BURIED = "measured with a buried reference"
    GIVEN = "given"
    SOIL = "typical of the soil"
    PLAN = OF_PLAN
    ENTERED = ENTERED
    ASSUMED = "assumed"

    @property
    def message(self) -> Message:
        """For people."""
        return _MESSAGES[self]


_MESSAGES = {
    Source.SURFACE: Message("MEASURED at the surface against a metal plate"),
    Source.BURIED: Message("MEASURED with the buried reference"),
    Source.GIVEN: Message("as given"),
    Source.SOIL: Message("TYPICAL of the chosen soil, not measured"),
    Source.PLAN: Message("of the plan of the survey"),
    Source.ENTERED: Message("entered later, in the log of the survey"),
    Source.ASSUMED: Message("ASSUMED, as nothing is known of the ground"),
}


@dataclass(frozen=True)
class KnownPermittivity:
    """A permittivity and how well it is known.

    Attributes:
        permittivity: Best value.
        lowest: Lowest likely value (95 % range).
        highest: Highest likely value.
        source: Where it is from.
    """

    permittivity: float
    lowest: float
    highest: float
    source: Source

    @classmethod
    def of_soil(cls, soil: Soil, source: Source) -> KnownPermittivity:
        """Return the usual permittivity of a soil."""
        return cls(soil.permittivity, soil.lowest, soil.highest, source)

    @classmethod
    def within(cls, permittivity: float, share: float, source: Source) -> KnownPermittivity:
        """Return a value that may be off by a share of it."""
        lowest = max(permittivity * (1.0 - share), 1.0)
        return cls(permittivity, lowest, permittivity * (1.0 + share), source)

    def attributes(self) -> Dict[str, object]:
        """Return the attributes of an image."""
        return {
            "permittivity_source": self.source.value,
            "permittivity_lowest": self.lowest,
            "permittivity_highest": self.highest,
            "depth_uncertainty": depth_shares(self.permittivity, self.lowest, self.highest)[0],
        }


def depth_shares(permittivity: float, lowest: float, highest: float) -> Tuple[float, float, float]:
    """Return by what share depths are uncertain at most, may be too small, and too large."""
    deeper = float(np.sqrt(permittivity / lowest)) - 1.0
    shallower = 1.0 - float(np.sqrt(permittivity / highest))
    return max(deeper, shallower), deeper, shallower


def permittivity_line(image: xr.Dataset) -> Message:
    """Return the permittivity of an image, where it is from, and the uncertainty of depths.

    Args:
        image: Dataset with `image`.
    """
    value = float(image.attrs["permittivity"])
    lowest, highest = permittivity_range(image)
    _, deeper, shallower = depth_shares(value, lowest, highest)
    return Message(
        "The soil's permittivity is {permittivity:.3g}, {source}; {lowest:.3g} to {highest:.3g} is "
        "likely, so depths may be wrong by {shallower:+.0f} % to {deeper:+.0f} %.",
        permittivity=value,
        source=Source(image.attrs.get("permittivity_source", Source.GIVEN.value)).message,
        lowest=lowest,
        highest=highest,
        shallower=-100.0 * shallower,
        deeper=100.0 * deeper,
    )


def permittivity_range(image: xr.Dataset) -> Tuple[float, float]:
    """Return the lowest and highest likely permittivity of an image, also of other programs."""
    value = float(image.attrs["permittivity"])
    lowest = float(image.attrs.get("permittivity_lowest", value * (1.0 - GIVEN_UNCERTAINTY)))
    highest = float(image.attrs.get("permittivity_highest", value * (1.0 + GIVEN_UNCERTAINTY)))
    return max(lowest, 1.0), highest
