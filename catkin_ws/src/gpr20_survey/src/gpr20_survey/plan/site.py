"""Which robot surveys where, for whom: what its owner knows, for the surveys to record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.plan.annotation import (
    MAX_NAME_CHARACTERS,
    Annotation,
    Wgs84Position,
    check_text,
)


@dataclass(frozen=True)
class Site:
    """The robot and its place.

    Attributes:
        robot: Name of the robot.
        site: Name of the site, proposed for each survey.
        operator: Who operates it, proposed for each survey.
        latitude_deg: WGS 84 latitude of the survey area [deg]; none if unknown.
        longitude_deg: WGS 84 longitude of the survey area [deg]; none if unknown.
    """

    robot: str = "GPR-20"
    site: str = ""
    operator: str = ""
    latitude_deg: Optional[float] = None
    longitude_deg: Optional[float] = None

    def __post_init__(self) -> None:
        check_text("robot", self.robot, MAX_NAME_CHARACTERS)
        _ = self.annotation

    @property
    def annotation(self) -> Annotation:
        """What is proposed for each survey."""
        latitude_deg, longitude_deg = self.latitude_deg, self.longitude_deg
        if latitude_deg is None and longitude_deg is None:
            return Annotation(self.operator, self.site)
        if latitude_deg is None or longitude_deg is None:
            raise InvalidValueError(
                Message(
                    "latitude_deg is {latitude} and longitude_deg is {longitude}; set both or none",
                    latitude=str(latitude_deg),
                    longitude=str(longitude_deg),
                ),
                fault=NOT_ALLOWED,
            )
        position = Wgs84Position(latitude_deg, longitude_deg)
        return Annotation(self.operator, self.site, position=position)
