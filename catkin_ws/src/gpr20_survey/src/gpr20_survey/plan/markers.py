"""Markers: places of a survey that people noted, with a text, while it was measured or later."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded, record_from
from gpr20_survey import faults
from gpr20_survey.plan.annotation import MAX_NAME_CHARACTERS, OPERATOR, check_text
from gpr20_survey.trace.trace import MAX_COORDINATE, SURVEY_ID

MARKERS = "markers"
"""Key of the description."""
MAX_TEXT_CHARACTERS = 500
# With every text as long as it may be, the log remains far below its own limit.
MAX_MARKERS = 1000
MAX_DEPTH_MM = 10_000.0
REQUEST_KEYS = ("marker_id", "x_mm", "y_mm", "depth_mm", "text", "author")
TEXT = Message("text of the marker")


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
