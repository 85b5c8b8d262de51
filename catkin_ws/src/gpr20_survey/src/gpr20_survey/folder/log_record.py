"""One line of a survey's log: a fact that does not change any more."""

from __future__ import annotations

import enum
import hashlib
import json
from dataclasses import dataclass, replace
from typing import Any, Dict, NamedTuple, Optional

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, MAX_FILE_DEPTH, parse_object

NO_RECORD = ""
"""What the first record has instead of the checksum of the record before it."""
MAX_NUMBER = 1_000_000
"""Of a record: the numbers up to that of the last one are counted."""


class Kind(str, enum.Enum):
    """What a record says; docs/reference/formats.md has what each kind holds."""

    PLAN = "plan"
    ANNOTATION = "annotation"
    MARKER = "marker"
    MARKER_REMOVED = "marker_removed"
    REPORT = "report"
    PAUSE = "pause"
    CONTINUE = "continue"
    RESUME = "resume"
    DECISION = "decision"
    CLOCK = "clock"
    EPOCH = "epoch"
    DRIFT = "drift"
    END = "end"
    FOUND = "found"
    EXPORT = "export"
    AUDIT = "audit"
    BAG = "bag"
    SEAL = "seal"
    UNCONFIRMED = "unconfirmed"


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
    """One fact."""

    number: int
    """Place in the log, from 0."""
    time: str
    """When it was added, as ISO 8601 text."""
    kind: str
    """One of `Kind`; a later version may have others."""
    values: Dict[str, Any]
    previous: str
    """Checksum of the record before it."""
    sha256: str
    """Of all else, in hexadecimal digits."""

    @classmethod
    def after(
        cls,
        last: Optional[LogRecord],
        kind: Kind,
        values: Dict[str, Any],
        time: str,
        lost: int = -1,
    ) -> LogRecord:
        """Return the record that follows another, None: the first, added at an ISO 8601 time.

        `lost` is the largest number of a record that was lost behind the other.
        """
        number = max(-1 if last is None else last.number, lost) + 1
        previous = NO_RECORD if last is None else last.sha256
        return cls(number, time, kind.value, values, previous, "").with_sum()

    def with_sum(self) -> LogRecord:
        """Return the record with the checksum that belongs to it."""
        *covered, _sum = vars(self).values()
        return replace(self, sha256=hashlib.sha256(_compact(covered)).hexdigest())

    def as_json(self) -> Dict[str, Any]:
        """Return the record as JSON holds it."""
        return dict(vars(self))

    def line(self) -> bytes:
        """Return the record as both files of the log hold it."""
        return _compact(self.as_json()) + b"\n"


class LogHead(NamedTuple):
    """Place and checksum of a record."""

    number: int
    sha256: str

    @classmethod
    def of(cls, record: LogRecord) -> LogHead:
        """Return those of a record."""
        return cls(record.number, record.sha256)


def is_number(value: Any) -> bool:
    """Return whether a value is the number of a record."""
    return type(value) is int and 0 <= value <= MAX_NUMBER


def record_of_line(line: bytes) -> Optional[LogRecord]:
    """Return the record of a line without its end, equal to the last byte, or None."""
    try:
        values = parse_object(line.decode("ascii"), "line", MAX_FILE_BYTES, MAX_FILE_DEPTH)
        record = LogRecord(**values)
    except (UnicodeDecodeError, SurveyRefusedError, TypeError):
        return None
    texts = (record.time, record.kind, record.previous, record.sha256)
    is_one = is_number(record.number) and isinstance(record.values, dict)
    is_one = is_one and all(isinstance(text, str) for text in texts)
    is_same = is_one and record.line() == line + b"\n" and record.with_sum() == record
    return record if is_same else None


def _compact(value: Any) -> bytes:
    return json.dumps(value, allow_nan=False, separators=(",", ":")).encode("ascii")
