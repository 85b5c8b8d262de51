"""The lines of a survey's log, facts that do not change any more, and what they say together."""

from __future__ import annotations

import enum
import hashlib
import json
from dataclasses import dataclass, replace
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.survey_metadata import (
    MAX_FILE_BYTES,
    MAX_FILE_DEPTH,
    NOT_ENDED,
    parse_object,
)
from gpr20_survey.plan.annotation import ANNOTATION
from gpr20_survey.plan.markers import MARKERS
from gpr20_survey.radar import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY
from gpr20_survey.trace import utc_time

NO_RECORD = ""
"""What the first record has instead of the checksum of the record before it."""
MAX_NUMBER = 1_000_000
"""Of a record: the numbers up to that of the last one are counted."""
LOG = "log"
"""Key of a description under which a reader gets records of the log beside it."""
UNCONFIRMED = "unconfirmed"
"""Key of a description: entries that nothing vouches for, by their names, with the reason."""


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
        *covered, _sum = vars(self).values()
        return replace(self, sha256=hashlib.sha256(_compact(covered)).hexdigest())

    def as_json(self) -> Dict[str, Any]:
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
        return cls(record.number, record.sha256)


def is_number(value: Any) -> bool:
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


def description_of(records: Sequence[LogRecord]) -> Dict[str, Any]:
    """Return what records say, in their order; the first one is the plan."""
    description: Dict[str, Any] = {}
    for record in records:
        add_to(description, record)
    return description


def add_to(description: Dict[str, Any], record: LogRecord) -> None:
    """Change a description by one record; those of other kinds than below change nothing."""
    kind, values = record.kind, record.values
    if kind == Kind.END or (kind == Kind.PLAN and record.number == 0):
        description.update(values)
    elif kind in (Kind.ANNOTATION, Kind.REPORT):
        description[ANNOTATION if kind == Kind.ANNOTATION else "report"] = values
    elif kind == Kind.MARKER:
        description[MARKERS] = [*description.get(MARKERS, []), values]
    elif kind == Kind.MARKER_REMOVED:
        description[MARKERS] = [
            {**one, **values} if one.get("marker_id") == values.get("marker_id") else one
            for one in description.get(MARKERS, [])
        ]
    elif kind == Kind.RESUME:
        resumed = [*description.get("resumed", []), record.time]
        description.update({**NOT_ENDED, **values, "resumed": resumed})
    elif kind == Kind.UNCONFIRMED:
        entries = values.get("entries", {})
        description[UNCONFIRMED] = {**description.get(UNCONFIRMED, {}), **entries}


def log_values(values: Mapping[str, Any], kind: Kind) -> List[Dict[str, Any]]:
    """Return the facts of a kind, of the records that a reader gets with a description."""
    log = values.get(LOG)
    entries = [one for one in log if isinstance(one, dict)] if isinstance(log, list) else []
    found = [one.get("values") for one in entries if one.get("kind") == kind.value]
    return [one for one in found if isinstance(one, dict)]


PLANNED_PERMITTIVITY = "permittivity"
"""Key of the description; only in a survey whose plan names the permittivity."""
SOIL_FORMAT = "gpr20-soil/1"
OF_PLAN, ENTERED = "of the plan", "entered later"
"""Where the permittivity of a survey is from."""


class KnownSoil(NamedTuple):
    """What a survey knows of its ground."""

    permittivity: float
    source: str


def soil_values(permittivity: Optional[float], time_us: int) -> Dict[str, Any]:
    """Return the values of the record at a moment [us since 1970]; None: not known after all."""
    return {"format": SOIL_FORMAT, "permittivity": permittivity, "time": utc_time.iso_text(time_us)}


def soil_of_survey(description: Mapping[str, Any]) -> Optional[KnownSoil]:
    """Return what a survey knows of its ground: the last decision in its log, or else its plan.

    Of its records the decisions are enough. None: it is not known, or not known after all.
    """
    found, source = description.get(PLANNED_PERMITTIVITY), OF_PLAN
    for values in log_values(description, Kind.DECISION):
        if values.get("format") == SOIL_FORMAT:
            found, source = values.get("permittivity"), ENTERED
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        return None
    # Written so that NaN is refused too.
    is_ground = MIN_PERMITTIVITY <= found <= LARGEST_PERMITTIVITY
    return KnownSoil(float(found), source) if is_ground else None
