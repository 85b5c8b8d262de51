"""One line of a survey's log: a fact that does not change any more."""

from __future__ import annotations

import enum
import hashlib
import json
from dataclasses import dataclass
from typing import Any, Dict, NamedTuple, Optional

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_metadata

NO_RECORD = ""
"""What the first record has instead of the checksum of the record before it."""
MAX_NUMBER = 1_000_000
"""Of a record: the numbers up to that of the last one are counted."""
KEYS = ("number", "time", "kind", "values", "previous", "sha256")


class Kind(str, enum.Enum):
    """What a record says."""

    PLAN = "plan"
    """The first record: what is to be measured, with which robot."""
    ANNOTATION = "annotation"
    MARKER = "marker"
    MARKER_REMOVED = "marker_removed"
    REPORT = "report"
    PAUSE = "pause"
    CONTINUE = "continue"
    RESUME = "resume"
    """The survey was opened again."""
    DECISION = "decision"
    """What the operator accepted."""
    CLOCK = "clock"
    """A remark on the computer's clock."""
    EPOCH = "epoch"
    """Other zeros of the axes."""
    DRIFT = "drift"
    """A visit of the first stop."""
    END = "end"
    FOUND = "found"
    EXPORT = "export"
    AUDIT = "audit"
    BAG = "bag"
    """survey.bag was written: its checksum."""
    SEAL = "seal"
    """The manifest was written again, or for a later state: why."""
    UNCONFIRMED = "unconfirmed"
    """Entries that nothing vouches for."""


NOTES = (
    Kind.PAUSE,
    Kind.CONTINUE,
    Kind.DECISION,
    Kind.CLOCK,
    Kind.EPOCH,
    Kind.DRIFT,
    Kind.FOUND,
    Kind.EXPORT,
    Kind.AUDIT,
)
"""Kinds that clients add, each with its own time, and that stay in the log alone."""


@dataclass(frozen=True)
class LogRecord:
    """One fact.

    Attributes:
        number: Place in the log, from 0.
        time: When it was added, as ISO 8601 text.
        kind: One of `Kind`; a later version may have others.
        values: What the fact is.
        previous: Checksum of the record before it; `NO_RECORD` of the first.
        sha256: SHA-256 of all else, in hexadecimal digits.
    """

    number: int
    time: str
    kind: str
    values: Dict[str, Any]
    previous: str
    sha256: str

    @classmethod
    def after(
        cls,
        last: Optional[LogRecord],
        kind: Kind,
        values: Dict[str, Any],
        time: str,
        lost: int = -1,
    ) -> LogRecord:
        """Return the record that follows another.

        Args:
            last: The record before it; None: it is the first of a log.
            kind: What it says.
            values: The fact.
            time: When it is added, as ISO 8601 text.
            lost: The largest number of a record that was lost behind `last`.
        """
        number = max(-1 if last is None else last.number, lost) + 1
        previous = NO_RECORD if last is None else last.sha256
        own_sum = _sum(number, time, kind.value, values, previous)
        return cls(number, time, kind.value, values, previous, own_sum)

    def as_json(self) -> Dict[str, Any]:
        """Return the record as JSON holds it."""
        return {key: getattr(self, key) for key in KEYS}

    def line(self) -> bytes:
        """Return the record as both files of the log hold it."""
        return _compact(self.as_json()) + b"\n"


class LogHead(NamedTuple):
    """The last record of a log, as a manifest names it."""

    number: int
    sha256: str

    @classmethod
    def of(cls, record: LogRecord) -> LogHead:
        """Return the place and the checksum of a record."""
        return cls(record.number, record.sha256)


def is_number(value: Any) -> bool:
    """Return whether a value is the number of a record."""
    return type(value) is int and 0 <= value <= MAX_NUMBER


def record_of_line(line: bytes) -> Optional[LogRecord]:
    """Return the record of a line without its end, equal to the last byte, or None."""
    try:
        values = survey_metadata.parse_object(
            line.decode("ascii"),
            "line",
            survey_metadata.MAX_FILE_BYTES,
            survey_metadata.MAX_FILE_DEPTH,
        )
    except (UnicodeDecodeError, SurveyRefusedError):
        return None
    if tuple(values) != KEYS or not is_number(values["number"]):
        return None
    texts = (values[key] for key in ("time", "kind", "previous", "sha256"))
    if not all(isinstance(one, str) for one in texts) or not isinstance(values["values"], dict):
        return None
    record = LogRecord(**values)
    own_sum = _sum(record.number, record.time, record.kind, record.values, record.previous)
    return record if own_sum == record.sha256 and record.line() == line + b"\n" else None


def _sum(number: int, time: str, kind: str, values: Dict[str, Any], previous: str) -> str:
    return hashlib.sha256(_compact([number, time, kind, values, previous])).hexdigest()


def _compact(value: Any) -> bytes:
    return json.dumps(value, allow_nan=False, separators=(",", ":")).encode("ascii")
