"""The log of a survey: log.jsonl, and survey.json, which holds the same records.

A fact is acknowledged when both are durable. Each record judges itself by its checksum, so each
of the two files repairs the other; see `log_record`.
"""

from __future__ import annotations

import enum
import itertools
import os
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files import access, durable_files
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_content import LOG, description_of, view_of
from gpr20_survey.folder.log_record import (
    NO_RECORD,
    Kind,
    LogRecord,
    json_of_line,
    record_of,
    record_of_line,
)

LOG_FILE = survey_folder.LOG_FILE


class State(enum.Enum):
    """In what state one of the two files is."""

    WHOLE = "whole"
    BEHIND = "behind"
    """It is right, but lacks the last record."""
    DAMAGED = "damaged"


MAX_LOG_BYTES = 1 << 30
Records = Mapping[int, LogRecord]


@dataclass(frozen=True)
class FoundLog:
    """What a folder holds of its survey's log.

    Attributes:
        records: Those that are right, in their order.
        lost: Numbers of records that no form holds and that no record names as lost.
        legible: What can be read of the lost ones, by number; nothing vouches for it.
        agrees: Whether every entry of both files is right and both have the same.
        has_log: Whether there is a log; a survey of an earlier version has survey.json alone.
        own: The content of survey.json without its records; None if it cannot be read.
        lines: The lines of log.jsonl; None if it cannot be read.
        view: The bytes of survey.json.
    """

    records: Tuple[LogRecord, ...] = ()
    lost: Tuple[int, ...] = ()
    legible: Mapping[int, Sequence[Any]] = field(default_factory=dict)
    agrees: bool = True
    has_log: bool = False
    own: Optional[Dict[str, Any]] = None
    lines: Optional[Sequence[bytes]] = None
    view: bytes = b""

    @cached_property
    def states(self) -> Mapping[str, State]:
        """In what state each of the two files is."""
        if not self.has_log:
            return {}
        return {
            LOG_FILE: _state_of_log(self.records, self.lines),
            survey_folder.SURVEY_FILE: _state_of_view(self.records, self.view),
        }

    @property
    def damage(self) -> Tuple[Message, ...]:
        """What is wrong in log.jsonl and survey.json."""
        return tuple(
            Message("{file} is damaged", file=name)
            for name, state in self.states.items()
            if state is State.DAMAGED
        )

    @property
    def behind(self) -> bool:
        """Whether one of them lacks the last record, as after a power cut while it was added."""
        return State.BEHIND in self.states.values()

    @property
    def is_whole(self) -> bool:
        """Whether both files are as they were written."""
        return not self.damage and not self.lost and not self.behind


class SurveyLog:
    """Adds records to the log of a survey whose folder is locked."""

    def __init__(self, folder: Path, records: Sequence[LogRecord], whole: bool) -> None:
        """Take the records that are right.

        Args:
            folder: The survey's folder.
            records: The records so far.
            whole: Whether log.jsonl holds exactly these; otherwise the next record that is added
                writes it again.
        """
        self._path = folder / LOG_FILE
        self._view = folder / survey_folder.SURVEY_FILE
        self._records = list(records)
        self._whole = whole

    @property
    def description(self) -> Dict[str, Any]:
        """The content of survey.json without its records."""
        return description_of(self._records)

    @property
    def last(self) -> LogRecord:
        """The record that was added last."""
        return self._records[-1]

    @property
    def records(self) -> Tuple[LogRecord, ...]:
        """All records."""
        return tuple(self._records)

    def next(self, kind: Kind, values: Dict[str, Any], time: str) -> LogRecord:
        """Return the record that `add` would add."""
        return LogRecord.after(self._records[-1] if self._records else None, kind, values, time)

    def add(self, record: LogRecord) -> LogRecord:
        """Add a record of `next`; return when it is durable in both files.

        Raises:
            OSError: The disk refused; the log has its former records, and the call may be
                repeated.
        """
        records = [*self._records, record]
        was_whole, self._whole = self._whole, False
        if was_whole:
            _append(self._path, record.line())
        else:
            durable_files.replace_file(self._path, b"".join(one.line() for one in records))
        durable_files.replace_file(self._view, view_of(records))
        self._records, self._whole = records, True
        return record

    def write(self) -> None:
        """Write both files again.

        Raises:
            OSError: The disk refused.
        """
        durable_files.replace_file(self._path, b"".join(one.line() for one in self._records))
        durable_files.replace_file(self._view, view_of(self._records))
        self._whole = True


def read_log(folder: Path, recorded: Iterable[LogRecord] = (), last: int = -1) -> FoundLog:
    """Return the log of a survey from log.jsonl and survey.json.

    Args:
        folder: The survey's folder.
        recorded: Records that were found elsewhere, as in a recording.
        last: Number of a record that was there; -1: not known.

    Raises:
        SurveyRefusedError: Neither file can be read, or survey.json is of another format.
    """
    lines = _read_lines(folder / LOG_FILE)
    content, own, failure = _read_view(folder / survey_folder.SURVEY_FILE)
    shown = own.pop(LOG, None) if own is not None else None
    in_log = _Form.of(lines or [], record_of_line, json_of_line)
    in_view = _Form.of(shown if isinstance(shown, list) else [], record_of)
    found = _merge([in_log.records, in_view.records, {one.number: one for one in recorded}])
    if not found and own is not None and shown is None:
        return FoundLog(own=own)
    if not found and failure is not None:
        raise failure
    # What is whole in survey.json was there when the last fact was acknowledged.
    view_is_whole = isinstance(shown, list) and not in_view.damaged
    lost = _lost(found, max(last, in_view.last, -1 if view_is_whole else in_log.last))
    agrees = not in_log.damaged and not in_view.damaged and in_log.last == in_view.last
    legible = _legible(lost, (*in_log.damaged, *in_view.damaged))
    return FoundLog(tuple(found), tuple(lost), legible, agrees, True, own, lines, content)


def _append(path: Path, line: bytes) -> None:
    descriptor = access.open_new(path, os.O_RDWR | os.O_APPEND)
    try:
        if os.write(descriptor, line) != len(line):
            raise OSError(f"{path}: the disk took a part of the line")
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _read_lines(path: Path) -> Optional[List[bytes]]:
    """Return the lines of log.jsonl; None if it cannot be read."""
    try:
        with open(open_regular(path), "rb") as stream:
            content = stream.read(MAX_LOG_BYTES + 1)
    except OSError:
        return None
    return content.split(b"\n") if len(content) <= MAX_LOG_BYTES else None


def _read_view(
    path: Path,
) -> Tuple[bytes, Optional[Dict[str, Any]], Optional[SurveyRefusedError]]:
    """Return survey.json and what it holds, or why it cannot be read."""
    try:
        content = survey_metadata.read_content(path)
        return content, survey_metadata.parse_view(content, path), None
    except SurveyRefusedError as error:
        return b"", None, error


@dataclass(frozen=True)
class _Form:
    """The entries of one of the two files."""

    records: Records
    """Those that are right."""
    damaged: Sequence[Any]
    """What can be read of the others."""
    last: int
    """Number that the last entry must have had, be it right or not; -1 without any."""

    @classmethod
    def of(
        cls,
        entries: Iterable[Any],
        record_of_entry: Callable[[Any], Optional[LogRecord]],
        legible: Callable[[Any], Any] = lambda entry: entry,
    ) -> _Form:
        """Return what is right in some entries, and what is not."""
        found: Dict[int, LogRecord] = {}
        damaged: List[Any] = []
        last = -1
        for entry in filter(None, entries):
            record = record_of_entry(entry)
            last = last + 1 if record is None else record.number
            if record is None:
                damaged.append(legible(entry))
            else:
                found.setdefault(record.number, record)
        return cls(found, damaged, last)


def _legible(lost: Sequence[int], damaged: Iterable[Any]) -> Dict[int, List[Any]]:
    found: Dict[int, List[Any]] = {}
    for one in damaged:
        number = one.get("number") if isinstance(one, dict) else None
        if number in lost:
            found.setdefault(number, []).append(one)
    return found


def _merge(forms: Sequence[Records]) -> List[LogRecord]:
    """Return the record of each number that is right, and follows the one before it."""
    numbers = sorted({number for form in forms for number in form})
    successors = {
        (number - 1, record.previous) for form in forms for number, record in form.items()
    }
    found: List[LogRecord] = []
    for number in numbers:
        candidates = [form[number] for form in forms if number in form]
        # One whose values were left out counts only if the record behind it names its checksum.
        confirmed = [
            one
            for one in candidates
            if one.values is not None or (number, one.sha256) in successors
        ]
        confirmed.sort(key=lambda one: one.values is None)
        fitting = [one for one in confirmed if _follows(found, one)]
        if fitting:
            found.append(fitting[0])
    return found


def _follows(found: Sequence[LogRecord], record: LogRecord) -> bool:
    if record.number == 0:
        return record.previous == NO_RECORD
    last = found[-1] if found else None
    # Behind a lost record nothing but its own checksum vouches for a record.
    return last is None or last.number < record.number - 1 or last.sha256 == record.previous


def _lost(found: Sequence[LogRecord], last: int) -> List[int]:
    present = {one.number for one in found}
    named = {
        number
        for one in found
        if one.kind == Kind.UNCONFIRMED.value and one.values is not None
        for number in one.values.get("lost", [])
    }
    last = max(last, found[-1].number if found else -1)
    return [number for number in range(last + 1) if number not in present | named]


def _state_of_log(found: Sequence[LogRecord], lines: Optional[Sequence[bytes]]) -> State:
    expected = [one.line()[:-1] for one in found]
    if lines is None:
        return State.DAMAGED
    if lines == [*expected, b""]:
        return State.WHOLE
    # The last line may be torn.
    return State.BEHIND if lines[:-1] == expected[: len(expected) - 1] else State.DAMAGED


def _state_of_view(found: Sequence[LogRecord], content: bytes) -> State:
    if content == view_of(found):
        return State.WHOLE
    # The log of a survey of an earlier version is begun before its survey.json is written again.
    former = (view_of(found[:-1]), survey_metadata.encode(description_of(found[:1])))
    return State.BEHIND if content in former else State.DAMAGED


def lost_entries(found: FoundLog) -> Dict[str, Any]:
    """Return the values of a record that names what is lost, for ever.

    Whatever can be read of it stands beside it, and is not used.
    """
    reason = "its checksum is wrong in every copy, or it is missing"
    entries = {
        _name(number, found.legible.get(number, ())): {
            "reason": reason,
            "found": [json_text(one) for one in found.legible.get(number, ())],
        }
        for number in found.lost
    }
    return {"lost": list(found.lost), "entries": entries}


def _name(number: int, legible: Sequence[Any]) -> str:
    known = {one.value for one in Kind}
    kinds = [one.get("kind") for one in legible if one.get("kind") in known]
    return f"record {number} ({kinds[0]})" if kinds else f"record {number}"


def json_text(value: Any) -> str:
    """Return a damaged value as text: nothing of it may be taken for an entry."""
    text = survey_metadata.encode({"value": value}).decode("ascii")
    return " ".join(itertools.islice(text.split(), 2000))
