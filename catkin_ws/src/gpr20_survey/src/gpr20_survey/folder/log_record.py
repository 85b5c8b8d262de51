"""One line of a survey's log: a fact that does not change any more."""

from __future__ import annotations

import enum
import hashlib
import json
from dataclasses import dataclass
from typing import Any, Dict, Optional

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
    END = "end"
    FOUND = "found"
    EXPORT = "export"
    AUDIT = "audit"
    UNCONFIRMED = "unconfirmed"
    """Entries that nothing vouches for."""


NOTES = (
    Kind.PAUSE,
    Kind.CONTINUE,
    Kind.DECISION,
    Kind.CLOCK,
    Kind.EPOCH,
    Kind.FOUND,
    Kind.EXPORT,
    Kind.AUDIT,
)
"""Kinds that stay in the log alone; the others change entries of survey.json."""


@dataclass(frozen=True)
class LogRecord:
    """One fact.

    Attributes:
        number: Place in the log, from 0.
        time: When it was added, as ISO 8601 text.
        kind: One of `Kind`; a later version may have others.
        values: What the fact is; None: a later record replaces them, and they were left out.
        previous: Checksum of the record before it; `NO_RECORD` of the first.
        sha256: SHA-256 of all else, in hexadecimal digits.
    """

    number: int
    time: str
    kind: str
    values: Optional[Dict[str, Any]]
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
        """Return the record as survey.json holds it."""
        return {key: getattr(self, key) for key in KEYS}

    def without_values(self) -> LogRecord:
        """Return the record without its values, which a later record replaces."""
        return LogRecord(self.number, self.time, self.kind, None, self.previous, self.sha256)

    def line(self) -> bytes:
        """Return the record as log.jsonl holds it."""
        return _compact(self.as_json()) + b"\n"


def is_number(value: Any) -> bool:
    """Return whether a value is the number of a record."""
    return type(value) is int and 0 <= value <= MAX_NUMBER


def record_of(values: Any) -> Optional[LogRecord]:
    """Return the record of a JSON value, or None if its checksum is not right.

    The checksum of a record whose values were left out cannot be calculated: the record that
    follows it confirms it.
    """
    if not isinstance(values, dict) or tuple(values) != KEYS:
        return None
    texts = (values[key] for key in ("time", "kind", "previous", "sha256"))
    if not is_number(values["number"]) or not all(isinstance(one, str) for one in texts):
        return None
    record = LogRecord(**values)
    if record.values is None and record.kind == Kind.REPORT.value:
        return record
    if not isinstance(record.values, dict):
        return None
    own_sum = _sum(record.number, record.time, record.kind, record.values, record.previous)
    return record if own_sum == record.sha256 else None


def record_of_line(line: bytes) -> Optional[LogRecord]:
    """Return the record of a line of log.jsonl, equal to the last byte, or None."""
    record = record_of(json_of_line(line))
    return record if record is not None and record.line() == line + b"\n" else None


def json_of_line(line: bytes) -> Optional[Dict[str, Any]]:
    """Return the JSON object of a line, right or not; None if it is none."""
    try:
        text = line.decode("ascii")
        return survey_metadata.parse_object(
            text, "line", survey_metadata.MAX_FILE_BYTES, survey_metadata.MAX_FILE_DEPTH
        )
    except (UnicodeDecodeError, SurveyRefusedError):
        return None


def _sum(number: int, time: str, kind: str, values: Dict[str, Any], previous: str) -> str:
    return hashlib.sha256(_compact([number, time, kind, values, previous])).hexdigest()


def _compact(value: Any) -> bytes:
    return json.dumps(value, allow_nan=False, separators=(",", ":")).encode("ascii")
