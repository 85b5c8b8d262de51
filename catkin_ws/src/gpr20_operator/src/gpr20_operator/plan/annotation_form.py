"""The annotation that the next survey will start with."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Callable, Dict, Mapping, Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.plan.annotation import (
    EMPTY,
    LATITUDE,
    LONGITUDE,
    MAX_NAME_CHARACTERS,
    MAX_NOTES_CHARACTERS,
    Annotation,
    Wgs84Position,
    degrees_from_text,
)

TITLES: Dict[str, Message] = {
    "name": Message("Name of the survey"),
    "operator": Message("Operator"),
    "site": Message("Site"),
    "latitude": Message("Latitude °"),
    "longitude": Message("Longitude °"),
    "notes": Message("Notes"),
}
HINTS: Dict[str, Message] = {
    "name": Message("at most {most} characters", most=MAX_NAME_CHARACTERS),
    "operator": Message("at most {most} characters", most=MAX_NAME_CHARACTERS),
    "site": Message("at most {most} characters", most=MAX_NAME_CHARACTERS),
    "latitude": Message("WGS 84, -90 to 90, north positive; empty if not known"),
    "longitude": Message("WGS 84, -180 to 180, east positive; empty if not known"),
    "notes": Message("at most {most} characters", most=MAX_NOTES_CHARACTERS),
}
_INCOMPLETE = Message("a position needs latitude and longitude; fill in both, or neither")


@dataclass(frozen=True)
class AnnotationCheck:
    """The result of a check.

    Attributes:
        annotation: What the texts say; None if one is wrong.
        problems: What is wrong, by the name of the field.
    """

    annotation: Optional[Annotation]
    problems: Mapping[str, Message]


def texts_of(annotation: Annotation) -> Dict[str, str]:
    """Return the text of each field."""
    position = annotation.position
    return {
        "name": annotation.name,
        "operator": annotation.operator,
        "site": annotation.site,
        "latitude": "" if position is None else repr(position.latitude_deg),
        "longitude": "" if position is None else repr(position.longitude_deg),
        "notes": annotation.notes,
    }


def check_texts(texts: Mapping[str, str]) -> AnnotationCheck:
    """Check the text of every field."""
    problems: Dict[str, Message] = {}
    place = {name: texts[name].strip() for name in ("latitude", "longitude")}
    checks: Dict[str, Callable[[], object]] = {
        "name": lambda: Annotation(name=texts["name"]),
        "operator": lambda: Annotation(operator=texts["operator"]),
        "site": lambda: Annotation(site=texts["site"]),
        "notes": lambda: Annotation(notes=texts["notes"]),
    }
    if place["latitude"]:
        checks["latitude"] = lambda: Wgs84Position(_latitude_deg(place), 0.0)
    if place["longitude"]:
        checks["longitude"] = lambda: Wgs84Position(0.0, _longitude_deg(place))
    for name, check in checks.items():
        try:
            check()
        except InvalidValueError as error:
            problems[name] = error.message
    empty = [name for name, text in place.items() if not text]
    if len(empty) == 1 and not problems:
        problems[empty[0]] = _INCOMPLETE
    if problems:
        return AnnotationCheck(None, problems)
    position = None if empty else Wgs84Position(_latitude_deg(place), _longitude_deg(place))
    written = {name: texts[name] for name in ("name", "operator", "site", "notes")}
    return AnnotationCheck(Annotation(**written, position=position, heading_deg=None), problems)


def _latitude_deg(place: Mapping[str, str]) -> float:
    return degrees_from_text(LATITUDE, place["latitude"])


def _longitude_deg(place: Mapping[str, str]) -> float:
    return degrees_from_text(LONGITUDE, place["longitude"])


_NUMBER_AT_END = re.compile(r"([0-9]{1,9})$", re.ASCII)


def first_name(site: str) -> str:
    """Return the name of the first survey at a site; empty if the site has no name."""
    return _joined(site.strip(), " 1") if site.strip() else ""


def next_name(name: str) -> str:
    """Return the name of the survey after one: "El Carmen 3" follows "El Carmen 2".

    The number keeps its leading zeros. A name without a number gets a 2; no name stays none.
    """
    if not name:
        return ""
    found = _NUMBER_AT_END.search(name)
    if found is None:
        return _joined(name, " 2")
    digits = found.group(1)
    return _joined(name[: found.start()], str(int(digits) + 1).zfill(len(digits)))


def _joined(before: str, after: str) -> str:
    return before[: MAX_NAME_CHARACTERS - len(after)] + after


class NextAnnotation:
    """Operator and site stay for the surveys that follow, and their names are numbered.

    Notes and position are for one survey.

    Attributes:
        value: The annotation.
    """

    def __init__(self) -> None:
        self.value = EMPTY

    def take_defaults(self, defaults: Annotation) -> None:
        """Fill the empty fields with those of the robot."""
        self.take(self.value.with_defaults(defaults))

    def take(self, annotation: Annotation) -> None:
        """Take over what the operator wrote, with a name if site is new and the name is not."""
        former, self.value = self.value, annotation
        if annotation.site != former.site and annotation.name in ("", first_name(former.site)):
            self.value = replace(annotation, name=first_name(annotation.site))

    def note_started(self) -> None:
        """Note that a survey has started with this annotation."""
        named = next_name(self.value.name)
        self.value = replace(self.value, name=named, notes="", position=None)
