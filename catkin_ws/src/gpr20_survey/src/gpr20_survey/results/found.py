"""What people found at a candidate: a record of the survey's log."""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Mapping, Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.mid.codec import plain, record_from
from gpr20_common.terminal_text import is_shown
from gpr20_survey.results.candidates import CANDIDATE_ID
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import MAX_COORDINATE

FORMAT = "gpr20-found/1"
PHOTOS = "photos"
"""Folder of a survey."""
PHOTO_ENDINGS = (".jpg", ".jpeg", ".png", ".heic", ".webp")
MAX_DEPTH_MM = 10_000.0
TEXTS = {
    "who": ".{1,500}",
    "notes": ".{0,500}",
    "candidate": CANDIDATE_ID,
    "list_sha256": "[0-9a-f]{64}",
    "photo": f"([0-9a-f]{{64}}({'|'.join(map(re.escape, PHOTO_ENDINGS))}))?",
}


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
        for name, form in TEXTS.items():
            text = getattr(self, name)
            if not (re.fullmatch(form, text) and all(map(is_shown, text))):
                refusal = Message(
                    "{name} is {text}; it must be one line of the form {form}",
                    **{"name": name, "text": repr(text[:80]), "form": form},
                )
                raise InvalidValueError(refusal)
        utc_time.parse_iso(self.time)

    def values(self) -> Dict[str, Any]:
        return {"format": FORMAT, **plain(self)}


def found_of(values: Mapping[str, Any]) -> Found:
    known = {name: value for name, value in values.items() if name != "format"}
    return record_from(Found, known, "found")


def present(records: Iterable[Found]) -> List[Found]:
    """Return the last record of each candidate of each list."""
    return list({(one.list_sha256, one.candidate): one for one in records}.values())
