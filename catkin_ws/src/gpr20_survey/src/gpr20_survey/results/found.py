"""What people found at a candidate, or elsewhere: a record of the survey's log."""

from __future__ import annotations

import enum
import math
import re
from dataclasses import asdict, dataclass
from typing import Any, Dict, Iterable, List, Mapping, Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.terminal_text import is_shown
from gpr20_survey.results.candidate_json import CANDIDATE_ID
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import MAX_COORDINATE

FORMAT = "gpr20-found/1"
PHOTOS = "photos"
"""Folder of a survey."""
PHOTO_NAME = re.compile(r"[0-9a-f]{64}\.(jpg|jpeg|png|heic|webp)")
MAX_DEPTH_MM, MAX_CHARACTERS = 10_000.0, 500
NUMBERS = (
    ("x_mm", -MAX_COORDINATE, MAX_COORDINATE),
    ("y_mm", -MAX_COORDINATE, MAX_COORDINATE),
    ("depth_mm", 0.0, MAX_DEPTH_MM),
    ("candidate_depth_mm", 0.0, MAX_DEPTH_MM),
)
TEXTS = (
    ("who", re.compile(".+")),
    ("notes", re.compile(".*")),
    ("candidate", re.compile(f"({CANDIDATE_ID.pattern})?")),
    ("list_sha256", re.compile("([0-9a-f]{64})?")),
    ("photo", re.compile(f"({PHOTO_NAME.pattern})?")),
)


class What(enum.Enum):
    """What was found."""

    NOTHING = "nothing"
    SCRAP = "scrap"
    DEVICE = "device"


LABELS = {
    What.NOTHING: Message("nothing"),
    What.SCRAP: Message("scrap"),
    What.DEVICE: Message("device"),
}
"""Their names, as people read them."""


@dataclass(frozen=True)
class Found:
    """What was found at a place. The id of a candidate means nothing without its list.

    A later record of the same candidate of the same list, or of the same place where no candidate
    is, replaces an earlier one; both stay in the log.
    """

    what: What
    x_mm: float  # place of the candidate, or of the object [mm], in the coordinates of the robot
    y_mm: float
    who: str
    time: str  # ISO 8601
    depth_mm: Optional[float] = None  # of the object, to its top [mm]
    candidate: str = ""  # its id; empty: there was none
    candidate_depth_mm: Optional[float] = None  # that the image shows [mm]
    list_sha256: str = ""  # of the file of the list of candidates
    photo: str = ""  # name in the folder of photographs: SHA-256 of the file, and its ending
    notes: str = ""

    def __post_init__(self) -> None:
        for name, least, most in NUMBERS:
            value = getattr(self, name)
            if value is not None or least < 0.0:
                is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
                number_between(name, value if is_number else math.nan, least, most, "mm")
        for name, form in TEXTS:
            text = getattr(self, name)
            is_text = isinstance(text, str) and len(text) <= MAX_CHARACTERS
            if not (is_text and form.fullmatch(text) and all(map(is_shown, text))):
                raise InvalidValueError(
                    Message(
                        "{name} is {text}; it must be one line of at most {most} letters and have "
                        "the form {form}",
                        name=name,
                        text=repr(str(text)[:64]),
                        most=MAX_CHARACTERS,
                        form=form.pattern,
                    )
                )
        utc_time.parse_iso(self.time)

    @property
    def subject(self) -> Any:
        """What it is about: records with the same are corrections of each other."""
        return (self.list_sha256, self.candidate) if self.candidate else (self.x_mm, self.y_mm)

    def values(self) -> Dict[str, Any]:
        """Return the values of its record in the log."""
        return {"format": FORMAT, **asdict(self), "what": self.what.value}


def found_of(values: Mapping[str, Any]) -> Found:
    """Return what a record of the log says.

    Raises:
        InvalidValueError: It is not as `Found.values` writes it.
    """
    try:
        known = dict(values)
        if known.pop("format") != FORMAT:
            raise ValueError("it has another format")
        return Found(**{**known, "what": What(known["what"])})
    except (KeyError, TypeError, ValueError) as error:
        message = Message("a record of what was found is not as it should be", details=error)
        raise InvalidValueError(message) from error


def present(records: Iterable[Found]) -> List[Found]:
    """Return the records that no later one replaces, in their order."""
    latest = {one.subject: one for one in records}
    return list(latest.values())
