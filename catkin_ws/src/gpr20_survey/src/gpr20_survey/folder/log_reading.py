"""Reading the log of a survey from log.jsonl and survey.json, of which each repairs the other.

Each record judges itself by its checksum; see `log_record`.
"""

from __future__ import annotations

import enum
import itertools
import json
import os
import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_content import LOG, description_of, view_of
from gpr20_survey.folder.log_merging import Records, contradicting, lost_numbers, merged
from gpr20_survey.folder.log_record import (
    LogRecord,
    json_of_line,
    record_of,
    record_of_line,
)
from gpr20_survey.folder.manifest import LogHead, Manifest

LOG_FILE = survey_folder.LOG_FILE
MAX_LOG_BYTES = 64 << 20
# How a record begins and ends in log.jsonl.
_BEGIN = re.compile(rb'\{"number":\d+,"time":"')
_END = re.compile(rb'"sha256":"[0-9a-f]{64}"\}')
# Where a record begins or ends in survey.json.
_EDGE = re.compile(r'(?=\n    \{\n      "number": )|(?<="sha256": "[0-9a-f]{64}"\n    \})')
_MIN_CHARS = 100  # of a record, which has a checksum or two of 64 digits


class State(enum.Enum):
    """In what state one of the two files is."""

    WHOLE = "whole"
    BEHIND = "behind"
    """It is right, but lacks the last record."""
    DAMAGED = "damaged"


@dataclass(frozen=True)
class FoundLog:
    """What a folder holds of its survey's log.

    Attributes:
        records: Those that are right, in their order.
        lost: Numbers of records that no form holds and that no record names as lost.
        legible: What can be read of the lost ones, by number; nothing vouches for it.
        contradicting: Records with a right checksum that are not of the log of the others.
        agrees: Whether every entry of both files is right and both have the same.
        has_log: Whether there is a log; a survey of an earlier version has survey.json alone.
        own: The content of survey.json without its records; None if it cannot be read.
        has_open_end: Whether neither file shows that the last of `records` is the last of the log.
        lines: The lines of log.jsonl; None if it cannot be read.
        view: The bytes of survey.json.
    """

    records: Tuple[LogRecord, ...] = ()
    lost: Tuple[int, ...] = ()
    legible: Mapping[int, Sequence[Any]] = field(default_factory=dict)
    contradicting: Tuple[LogRecord, ...] = ()
    agrees: bool = True
    has_log: bool = False
    own: Optional[Dict[str, Any]] = None
    has_open_end: bool = False
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


def read_log(
    folder: Path, recorded: Iterable[LogRecord] = (), sealed: Optional[Manifest] = None
) -> FoundLog:
    """Return the log of a survey from log.jsonl and survey.json.

    Args:
        folder: The survey's folder.
        recorded: Records that were found elsewhere, as in a recording.
        sealed: The survey's manifest, which names a record that the log had.

    Raises:
        SurveyRefusedError: Neither file can be read, or survey.json is of another format.
    """
    lines = _read_lines(folder / LOG_FILE)
    content, own, failure = _read_view(folder / survey_folder.SURVEY_FILE)
    listed = None if own is None else own.pop(LOG, None)
    shown = listed if isinstance(listed, list) else _salvaged(content)
    in_log, damaged_lines = _records_of(lines or [], record_of_line, json_of_line)
    in_view, damaged_entries = _records_of(shown or [], record_of)
    forms = [in_log, in_view, {one.number: one for one in recorded}]
    heads = () if sealed is None else tuple(filter(None, (sealed.log, sealed.next_log)))
    found = merged(forms, heads)
    if not found and own is not None and shown is None:
        return FoundLog(own=own)
    if not found and failure is not None:
        raise failure
    # A fact is acknowledged when it is in survey.json too: if that is whole, a line that it lacks
    # was torn while it was added.
    is_whole = shown is listed is not None and not damaged_entries
    ends = (
        -1 if sealed is None or sealed.log is None else sealed.log.number,
        -1 if is_whole else _lines_behind(lines or [], in_log),
        _entries_behind(shown or [], found),
    )
    lost = lost_numbers(found, max(ends))
    damaged = (*damaged_lines, *damaged_entries)
    return FoundLog(
        tuple(found),
        tuple(lost),
        _legible(lost, damaged),
        contradicting(found, forms),
        agrees=own is not None and bool(in_log) and not damaged and _sums(in_log) == _sums(in_view),
        has_log=True,
        own=own,
        has_open_end=not (in_log or in_view) or (own is None and _is_torn(lines)),
        lines=lines,
        view=content,
    )


def _is_torn(lines: Optional[Sequence[bytes]]) -> bool:
    return not lines or lines[-1] != b""


def _read_lines(path: Path) -> Optional[List[bytes]]:
    """Return the lines of log.jsonl; None if it cannot be read."""
    try:
        with open(open_regular(path), "rb") as stream:
            # Before it is read, so that a huge file takes no memory.
            survey_metadata.check_size(os.fstat(stream.fileno()).st_size, path.name, MAX_LOG_BYTES)
            return stream.read().split(b"\n")
    except (OSError, SurveyRefusedError):
        return None


def _read_view(
    path: Path,
) -> Tuple[bytes, Optional[Dict[str, Any]], Optional[SurveyRefusedError]]:
    """Return survey.json and what it holds, or why it cannot be read."""
    content = b""
    try:
        content = survey_metadata.read_content(path)
        return content, survey_metadata.parse_view(content, path), None
    except SurveyRefusedError as error:
        return content, None, error


def _salvaged(content: bytes) -> Optional[List[Any]]:
    """Return the records in a survey.json that is no JSON as a whole; "?" for a damaged one."""
    _, *pieces = _EDGE.split(content.decode("ascii", "replace"))
    return [_salvaged_entry(one) for one in pieces if len(one) > _MIN_CHARS] or None


def _salvaged_entry(piece: str) -> Any:
    try:
        return json.loads(piece)
    except (ValueError, RecursionError):
        return "?"


def _records_of(
    entries: Iterable[Any],
    record_of_entry: Callable[[Any], Optional[LogRecord]],
    legible: Callable[[Any], Any] = lambda entry: entry,
) -> Tuple[Records, List[Any]]:
    """Return the records that are right, and what can be read of the others."""
    found: Dict[int, LogRecord] = {}
    damaged: List[Any] = []
    for entry in filter(None, entries):
        record = record_of_entry(entry)
        if record is None:
            damaged.append(legible(entry))
        elif record.number not in found or found[record.number].values is None:
            # One without values may have a wrong number: it is in the way of no other one.
            found[record.number] = record
    return found, damaged


def _legible(lost: Sequence[int], damaged: Iterable[Any]) -> Dict[int, List[Any]]:
    found: Dict[int, List[Any]] = {}
    for one in damaged:
        number = one.get("number") if isinstance(one, dict) else None
        if type(number) is int and number in lost:
            found.setdefault(number, []).append(one)
    return found


def _sums(records: Records) -> Dict[int, str]:
    return {number: one.sha256 for number, one in records.items()}


def _lines_behind(lines: Sequence[bytes], records: Records) -> int:
    """Return the number of the last record of log.jsonl, although it is damaged.

    Of the end of a line that was torn nothing was acknowledged.
    """
    damaged: List[bytes] = []
    for line in filter(None, lines[:-1]):
        damaged = [] if record_of_line(line) is not None else [*damaged, line]
    # A changed byte may have made two lines of one, or one of two.
    begun, ended = (len(one.findall(b"\n".join(damaged))) for one in (_BEGIN, _END))
    return max(records, default=-1) + max(begun, ended, min(1, len(damaged)))


def _entries_behind(entries: Sequence[Any], found: Sequence[LogRecord]) -> int:
    """Return the number of the last record in survey.json, although it is damaged."""
    right = {LogHead.of(one) for one in found}
    for behind, entry in enumerate(reversed(entries)):
        record = record_of(entry)
        if record is not None and LogHead.of(record) in right:
            return record.number + behind
    return len(entries) - 1


def _state_of_log(found: Sequence[LogRecord], lines: Optional[Sequence[bytes]]) -> State:
    expected = [one.line()[:-1] for one in found]
    if lines is None:
        return State.DAMAGED
    if lines == [*expected, b""]:
        return State.WHOLE
    # The last line, or one that was being added, may be torn.
    added = [one for one in lines[len(expected) :] if one]
    if lines[: len(expected)] == expected and len(added) <= 1:
        return State.BEHIND
    return State.BEHIND if lines[:-1] == expected[:-1] else State.DAMAGED


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
    entries = {
        f"record {number}": {
            "reason": "its checksum is wrong in every copy, or it is missing",
            "found": [json_text(one) for one in found.legible.get(number, ())],
        }
        for number in found.lost
    }
    for one in found.contradicting:
        entries[f"record {one.number}, {one.sha256[:8]}"] = {
            "reason": "it is not of the log of the other records",
            "found": [json_text(one.as_json())],
        }
    return {"lost": list(found.lost), "entries": entries}


def json_text(value: Any) -> str:
    """Return a damaged value as text: nothing of it may be taken for an entry."""
    text = survey_metadata.encode({"value": value}).decode("ascii")
    return " ".join(itertools.islice(text.split(), 2000))
