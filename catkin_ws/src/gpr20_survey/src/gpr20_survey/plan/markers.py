"""What people note at a place of a survey: a marker, and what they found at a candidate."""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.mid.codec import bounded, plain, record_from
from gpr20_common.terminal_text import is_shown
from gpr20_survey import faults
from gpr20_survey.plan.annotation import MAX_NAME_CHARACTERS, OPERATOR, check_text
from gpr20_survey.results.candidates import CANDIDATE_ID
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import MAX_COORDINATE, SURVEY_ID

MARKERS = "markers"
"""Key of the description."""
MAX_TEXT_CHARACTERS = 500
# With every text as long as it may be, the log remains far below its own limit.
MAX_MARKERS = 1000
MAX_DEPTH_MM = 10_000.0
REQUEST_KEYS = ("marker_id", "x_mm", "y_mm", "depth_mm", "text", "author")
TEXT = Message("text of the marker")
FOUND_FORMAT = "gpr20-found/1"
PHOTOS = "photos"
"""Folder of a survey."""
PHOTO_ENDINGS = (".jpg", ".jpeg", ".png", ".heic", ".webp")
FOUND_TEXTS = {
    "who": ".{1,500}",
    "notes": ".{0,500}",
    "candidate": CANDIDATE_ID,
    "list_sha256": "[0-9a-f]{64}",
    "photo": f"([0-9a-f]{{64}}({'|'.join(map(re.escape, PHOTO_ENDINGS))}))?",
}


@dataclass(frozen=True)
class Marker:
    """A place that somebody noted; one that was removed stays in the list.

    The client makes the UUID; the coordinates are those of the robot, the depth is below the
    surface. The storage adds `time` and `removed`, when it took and removed it [ISO 8601].
    """

    marker_id: str
    x_mm: float = bounded(-MAX_COORDINATE, MAX_COORDINATE)
    y_mm: float = bounded(-MAX_COORDINATE, MAX_COORDINATE)
    depth_mm: Optional[float] = bounded(0.0, MAX_DEPTH_MM, None)
    text: str = ""
    author: str = ""
    time: str = ""
    removed: str = ""
    removed_by: str = ""

    def __post_init__(self) -> None:
        if not SURVEY_ID.fullmatch(self.marker_id):
            raise InvalidValueError(
                Message(
                    "marker_id is {marker}; it must be a UUID in lower case with hyphens",
                    marker=repr(self.marker_id[:64]),
                )
            )
        check_text(TEXT, self.text, MAX_TEXT_CHARACTERS)
        for name in (self.author, self.removed_by):
            check_text(OPERATOR, name, MAX_NAME_CHARACTERS)

    @property
    def is_present(self) -> bool:
        return not self.removed

    def request(self) -> Dict[str, Any]:
        """Return what a client says of it, without the times."""
        return {key: getattr(self, key) for key in REQUEST_KEYS}

    def same_request(self, other: Marker) -> bool:
        """Return whether another marker was made by the same request, whenever it came."""
        return self.request() == other.request()


def markers_of(description: Mapping[str, Any]) -> Tuple[Marker, ...]:
    """Return all markers of a survey in the order in which they were made, removed ones too.

    Raises:
        InvalidValueError: Its markers are not those that the storage writes.
    """
    kind: Any = Tuple[Marker, ...]
    try:
        found: Tuple[Marker, ...] = record_from(kind, description.get(MARKERS, ()), MARKERS)
        if len(found) > MAX_MARKERS or len({one.marker_id for one in found}) != len(found):
            raise InvalidValueError(Message("there are too many, or two of one id"))
    except InvalidValueError as error:
        raise InvalidValueError(
            Message("the markers in the log are damaged", details=error),
            fault=faults.DAMAGED,
        ) from error
    return found


def present_markers(description: Mapping[str, Any]) -> Tuple[Marker, ...]:
    """Return the markers of a survey that were not removed; see `markers_of`."""
    return tuple(one for one in markers_of(description) if one.is_present)


class What(enum.Enum):
    """What was found."""

    NOTHING = "nothing"
    SCRAP = "scrap"
    DEVICE = "device"


@dataclass(frozen=True)
class Found:
    """What was found at a candidate, whose id means nothing without its list."""

    what: What
    candidate: str  # its id
    list_sha256: str  # of the file of the list of candidates
    x_mm: float  # its place [mm], in the coordinates of the robot
    y_mm: float
    who: str
    time: str  # ISO 8601
    depth_mm: Optional[float] = None  # of the object, to its top [mm]
    photo: str = ""  # name in the folder of photographs: SHA-256 of the file, and its ending
    notes: str = ""

    def __post_init__(self) -> None:
        for name in ("x_mm", "y_mm"):
            number_between(name, getattr(self, name), -MAX_COORDINATE, MAX_COORDINATE, "mm")
        if self.depth_mm is not None:
            number_between("depth_mm", self.depth_mm, 0.0, MAX_DEPTH_MM, "mm")
        for name, form in FOUND_TEXTS.items():
            text = getattr(self, name)
            if not (re.fullmatch(form, text) and all(map(is_shown, text))):
                refusal = Message(
                    "{name} is {text}; it must be one line of the form {form}",
                    **{"name": name, "text": repr(text[:80]), "form": form},
                )
                raise InvalidValueError(refusal)
        utc_time.parse_iso(self.time)

    def values(self) -> Dict[str, Any]:
        return {"format": FOUND_FORMAT, **plain(self)}


def found_of(values: Mapping[str, Any]) -> Found:
    known = {name: value for name, value in values.items() if name != "format"}
    return record_from(Found, known, "found")


def present(records: Iterable[Found]) -> List[Found]:
    """Return the last record of each candidate of each list."""
    return list({(one.list_sha256, one.candidate): one for one in records}.values())
