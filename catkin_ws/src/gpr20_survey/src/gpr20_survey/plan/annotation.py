"""What people add to a survey: its name, who measured it, where, and notes."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass, replace
from typing import Any, Dict, Mapping, Optional, Union

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.mid.codec import bounded, plain, record_from
from gpr20_common.terminal_text import is_shown

ANNOTATION = "annotation"
"""Key of the description."""
NAME, NOTES = Message("name"), Message("notes")
OPERATOR, SITE = Message("operator"), Message("site")
LATITUDE, LONGITUDE = Message("latitude"), Message("longitude")
HEADING = Message("heading")
MAX_NAME_CHARACTERS = 200
MAX_NOTES_CHARACTERS = 4000
MAX_HEADING_DEG = 360.0
FALSE_ALARMS_PER_M2, USUAL_FALSE_ALARMS_PER_M2 = (0.3, 20.0), 10.0
"""Rates at which lists of candidates may be cut, and the usual one [1/m2]."""

# Not float() alone: it accepts digits of other scripts, and words. Some floats need an exponent.
_DECIMAL = re.compile(r"[-+]?[0-9]{1,20}(\.[0-9]{0,20})?(e[-+]?[0-9]{1,3})?", re.ASCII)

Name = Union[str, Message]


@dataclass(frozen=True)
class Wgs84Position:
    """Geodetic latitude, north positive, and longitude, east positive [deg]."""

    latitude_deg: float
    longitude_deg: float

    def __post_init__(self) -> None:
        number_between(LATITUDE, self.latitude_deg, -90.0, 90.0, Message("deg"))
        number_between(LONGITUDE, self.longitude_deg, -180.0, 180.0, Message("deg"))

    def __str__(self) -> str:
        return f"{self.latitude_deg!r}, {self.longitude_deg!r}"


@dataclass(frozen=True)
class Annotation:
    """What people add to a survey; everything in it may be empty, and may be changed later.

    The heading is the direction of +Y, clockwise from true north, 0 to 360 [deg]. Folder and id of
    a survey do not depend on its name.
    """

    operator: str = ""
    site: str = ""
    notes: str = ""
    position: Optional[Wgs84Position] = None
    heading_deg: Optional[float] = None
    name: str = ""

    def __post_init__(self) -> None:
        check_text(NAME, self.name, MAX_NAME_CHARACTERS)
        check_text(OPERATOR, self.operator, MAX_NAME_CHARACTERS)
        check_text(SITE, self.site, MAX_NAME_CHARACTERS)
        check_text(NOTES, self.notes, MAX_NOTES_CHARACTERS, lines=True)
        if self.heading_deg is not None:
            number_between(HEADING, self.heading_deg, 0.0, MAX_HEADING_DEG, Message("deg"))

    def with_defaults(self, defaults: Annotation) -> Annotation:
        """Return this annotation with its empty fields taken from another one.

        Name and notes are those of one survey, so they have no default.
        """
        return replace(
            self,
            operator=self.operator or defaults.operator,
            site=self.site or defaults.site,
            position=self.position or defaults.position,
        )

    def values(self) -> Dict[str, Any]:
        return dict(plain(self))

    def fields(self) -> Dict[str, Any]:
        """Return the fields of the ROS message gpr20_msgs/Annotation, which has no heading."""
        return {
            **{name: getattr(self, name) for name in ("name", "operator", "site", "notes")},
            "has_position": self.position is not None,
            **asdict(self.position or Wgs84Position(0.0, 0.0)),
        }


def from_fields(fields: Any) -> Annotation:
    """Return the annotation of a ROS message gpr20_msgs/Annotation.

    Raises:
        InvalidValueError: A field is not allowed.
    """
    position = None
    if fields.has_position:
        position = Wgs84Position(fields.latitude_deg, fields.longitude_deg)
    return Annotation(fields.operator, fields.site, fields.notes, position, name=fields.name)


def annotation_of(description: Mapping[str, Any]) -> Annotation:
    """Return the annotation of a survey; empty if it has none.

    Raises:
        InvalidValueError: It has one that is not allowed.
    """
    return record_from(Annotation, description.get(ANNOTATION, {}), ANNOTATION)


def position_from_text(text: str) -> Wgs84Position:
    """Return the position of a text such as "4.60283, -74.06514" or "4,60283; -74,06514".

    Raises:
        InvalidValueError: It is not two decimal numbers with a comma or a semicolon between them,
            or not on the earth.
    """
    # Many countries write 4,6.
    parts = [one.strip().replace(",", ".") for one in text.split(";" if ";" in text else ",")]
    if len(parts) != 2 or not all(map(_DECIMAL.fullmatch, parts)):
        raise InvalidValueError(
            Message(
                "position is {text}; it must be latitude and longitude, such as {example}",
                text=repr(text[:64]),
                example="4.60283,-74.06514",
            )
        )
    return Wgs84Position(*map(float, parts))


def check_text(name: Name, text: str, most: int, lines: bool = False) -> None:
    """Check that a text of an annotation, in any script, has at most so many characters.

    Raises:
        InvalidValueError: It is too long, or has characters that cannot be shown.
    """
    if len(text) > most:
        raise InvalidValueError(
            Message(
                "{name} has {count} characters; at most {most} are allowed",
                name=name,
                count=len(text),
                most=most,
            )
        )
    for place, character in enumerate(text, 1):
        if not is_shown(character) and not (lines and character == "\n"):
            raise InvalidValueError(
                Message(
                    "{name} holds {character} at character {place}, which cannot be shown; remove "
                    "it",
                    name=name,
                    character=f"U+{ord(character):04X}",
                    place=place,
                )
            )


EMPTY = Annotation()


@dataclass(frozen=True)
class Site:
    """Which robot surveys where, for whom: what its owner knows, for the surveys to record.

    Attributes:
        robot: Name of the robot.
        site: Name of the site, proposed for each survey.
        operator: Who operates it, proposed for each survey.
        latitude_deg: WGS 84 latitude of the survey area [deg]; none if unknown.
        longitude_deg: WGS 84 longitude of the survey area [deg]; none if unknown.
        false_alarms_per_m2: Where lists of candidates are cut: so many echoes of ground without
            bodies are listed in a square metre [1/m2].
    """

    robot: str = "GPR-20"
    site: str = ""
    operator: str = ""
    latitude_deg: Optional[float] = bounded(-90.0, 90.0, None)
    longitude_deg: Optional[float] = bounded(-180.0, 180.0, None)
    false_alarms_per_m2: float = bounded(*FALSE_ALARMS_PER_M2, USUAL_FALSE_ALARMS_PER_M2)

    def __post_init__(self) -> None:
        check_text("robot", self.robot, MAX_NAME_CHARACTERS)
        _ = self.annotation

    @property
    def annotation(self) -> Annotation:
        position = None
        if self.latitude_deg is not None and self.longitude_deg is not None:
            position = Wgs84Position(self.latitude_deg, self.longitude_deg)
        elif self.latitude_deg != self.longitude_deg:
            raise InvalidValueError(
                Message(
                    "latitude_deg is {latitude} and longitude_deg is {longitude}; set both or none",
                    latitude=str(self.latitude_deg),
                    longitude=str(self.longitude_deg),
                )
            )
        return Annotation(self.operator, self.site, position=position)
