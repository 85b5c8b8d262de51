"""Which robot surveys where, for whom: what its owner knows, for the surveys to record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between

MAX_CHARACTERS = 200


@dataclass(frozen=True)
class Site:
    """The robot and its place.

    Attributes:
        robot: Name of the robot.
        site: Name of the site.
        operator: Who operates it.
        latitude_deg: WGS 84 latitude of the survey area [deg]; none if unknown.
        longitude_deg: WGS 84 longitude of the survey area [deg]; none if unknown.
    """

    robot: str = "GPR-20"
    site: str = ""
    operator: str = ""
    latitude_deg: Optional[float] = None
    longitude_deg: Optional[float] = None

    def __post_init__(self) -> None:
        for name in ("robot", "site", "operator"):
            text = getattr(self, name)
            if len(text) > MAX_CHARACTERS or not text.isprintable():
                raise InvalidValueError(
                    Message(
                        "{name} is {value}; it must be one line of at most {most} characters",
                        name=name,
                        value=repr(text[:64]),
                        most=MAX_CHARACTERS,
                    )
                )
        for name, most_deg in (("latitude_deg", 90.0), ("longitude_deg", 180.0)):
            value = getattr(self, name)
            number_between(name, 0.0 if value is None else value, -most_deg, most_deg, "deg")
        if (self.latitude_deg is None) != (self.longitude_deg is None):
            raise InvalidValueError(
                Message(
                    "latitude_deg is {latitude} and longitude_deg is {longitude}; set both or none",
                    latitude=str(self.latitude_deg),
                    longitude=str(self.longitude_deg),
                )
            )
