"""The log of a survey: two equal files that are only appended to, and repair each other.

A fact is acknowledged when its line is durable in both. A line judges itself by its checksum, and
names that of the line before it. It is taken from the file in which it is whole; what is whole in
neither is lost, and named for ever.
"""

from __future__ import annotations

import json
import os
import re
from bisect import bisect_left
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

from gpr20_common.terminal_text import printable
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_files import open_regular
from gpr20_survey.folder import survey_metadata
from gpr20_survey.folder.log_record import NOTES, Kind, LogHead, LogRecord, add_to, record_of_line
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.survey_folder import DAMAGED_FOLDER, LOG_FILE, LOG_FILES, SURVEY_FILE

MAX_LOG_BYTES = 63 << 20
# Records that are added to a full log too: without them no survey is opened, closed and sealed.
NEEDED = (Kind.PLAN, Kind.RESUME, Kind.UNCONFIRMED, Kind.END, Kind.BAG, Kind.SEAL)
READ_BYTES = 256 << 20  # far more than those make of a full log
MAX_NAMED = 1000
LOST = (
    "its checksum is wrong in both files of the log, or it is missing; what is left of it is in "
    f"{DAMAGED_FOLDER}/"
)
STRANGER = f"it is not of the log of the other records; it is in {DAMAGED_FOLDER}/"
# How a record begins and ends in its line.
_BOUNDS = (rb'\{"number":\d+,"time":"', rb'"sha256":"[0-9a-f]{64}"\}')


@dataclass(frozen=True)
class FoundLog:
    """What a folder holds of its survey's log."""

    records: Tuple[LogRecord, ...]
    """Those that are right, in their order."""
    lost: Tuple[int, ...]
    """Numbers of records that neither file holds and that no record names as lost."""
    strangers: Tuple[LogRecord, ...]
    """Records with a right checksum that are not of the log of the others."""
    damaged: Tuple[str, ...]
    """Names of the files that are damaged or missing."""
    behind: Tuple[str, ...]
    """Names of the files that lack records at their end, as after power cuts."""

    @property
    def is_whole(self) -> bool:
        """Whether both files are as they were written."""
        return not (self.damaged or self.behind or self.lost)

    def lost_entries(self) -> Dict[str, Any]:
        """Return what a record must name of what is lost, for ever."""
        if len(self.lost) > MAX_NAMED:
            return {f"{len(self.lost)} records from {self.lost[0]} on": {"reason": LOST}}
        reasons = {f"record {one}": LOST for one in self.lost}
        for one in self.strangers[:MAX_NAMED]:
            reasons[f"record {one.number}, {one.sha256[:8]}"] = STRANGER
        return {name: {"reason": reason} for name, reason in reasons.items()}


class _Form(NamedTuple):
    """One of the two files."""

    records: List[LogRecord]
    end: int
    """Number of the last record that there was, although it may be damaged."""
    is_torn: bool
    """Whether it ends within a line."""
    is_sound: bool
    """Whether it ends with a whole line, and has no other ones."""


def read_log(folder: Path, sealed: Optional[Manifest] = None) -> FoundLog:
    """Return the log of a survey, which had a record by its own manifest; nothing is changed.

    Raises:
        SurveyRefusedError: A file is larger than any log.
    """
    contents = [_content(folder / name) for name in LOG_FILES]
    first = _form(contents[0] or b"")
    forms = [first, first if contents[1] == contents[0] else _form(contents[1] or b"")]
    found = _own_chain(forms, folder.name, sealed)
    is_own = bool(found) and found[0].values.get("survey_id") == getattr(sealed, "survey_id", "")
    strangers = {LogHead.of(one): one for form in forms for one in form.records}
    for record in found:
        del strangers[LogHead.of(record)]
    named = sealed.log.number if sealed is not None and is_own else -1
    ends = [named]
    for own, other in (forms, forms[::-1]):
        # Of a line that was torn while it was added nothing was acknowledged, if the other file,
        # which a power cut leaves alone, shows that it was.
        ends.append(own.end + (own.is_torn and not other.is_sound))
    lost = tuple(_lost_numbers(found, max(ends)))
    lines = [one.line() for one in found]
    whole = b"".join(lines)
    differ = {name: one for name, one in zip(LOG_FILES, contents) if one != whole}
    # Where something is lost, a torn end is no trace of a power cut. Both files held the plan, and
    # what the manifest names.
    least = sum(len(line) for one, line in zip(found, lines) if one.number <= max(named, 0))
    behind = [name for name, one in differ.items() if not lost and _is_behind(one, whole, least)]
    return FoundLog(
        tuple(found),
        lost,
        tuple(strangers[one] for one in sorted(strangers)),
        tuple(name for name in differ if name not in behind),
        tuple(behind),
    )


def _content(path: Path) -> Optional[bytes]:
    try:
        with open(open_regular(path), "rb") as stream:
            # Before it is read, so that a huge file takes no memory.
            size = os.fstat(stream.fileno()).st_size
            survey_metadata.check_size(size, printable(path), READ_BYTES)
            return stream.read()
    except OSError:
        return None


def _form(content: bytes) -> _Form:
    *lines, tail = content.split(b"\n")
    read = [(line, record_of_line(line)) for line in lines if line]
    last = record_of_line(tail)
    records = [one for _line, one in [*read, (tail, last)] if one is not None]
    is_torn = last is None and bool(tail.strip(b"\0"))
    is_sound = bool(records) and not is_torn and all(one is not None for _line, one in read)
    unread = takewhile(lambda one: one[1] is None, reversed(read)) if last is None else ()
    behind = b"\n".join(line for line, _record in unread)
    # A changed byte may have made two lines of one, or one of two.
    more = max(bool(behind), *(len(re.findall(one, behind)) for one in _BOUNDS))
    end = max((one.number for one in records), default=-1) + more
    return _Form(records, end, is_torn, is_sound)


def _own_chain(forms: Sequence[_Form], folder: str, sealed: Optional[Manifest]) -> List[LogRecord]:
    """Return the records that name each other; of several chains that which belongs here."""

    def merit(records: Sequence[LogRecord]) -> Tuple[bool, bool, int, int]:
        survey = records[0].values.get("survey_id") if records and not records[0].number else None
        links = sum(one.sha256 == other.previous for one, other in zip(records, records[1:]))
        is_own = folder.endswith(f"_{str(survey)[:8]}")
        has_sealed = sealed is not None and sealed.covers(records)
        return has_sealed, is_own, links, len(records)

    best_last = sorted((one.records for one in forms), key=merit)
    every = {one.sha256: one for records in best_last for one in records}
    by_number = sorted(every.values(), key=lambda one: one.number)
    numbers = [one.number for one in by_number]

    def ending_with(last: LogRecord) -> List[LogRecord]:
        chain = [last]
        while chain[-1].number > 0:
            before = every.get(chain[-1].previous)
            if before is None or before.number >= chain[-1].number:
                # Behind a lost record nothing but its own checksum vouches for a record.
                place = bisect_left(numbers, chain[-1].number - 1)
                if place == 0:
                    break
                before = by_number[place - 1]
            chain.append(before)
        return chain[::-1]

    named = {one.previous for one in by_number}
    ends = [one for one in by_number if one.sha256 not in named]
    return max(map(ending_with, ends), key=merit, default=[])


def _lost_numbers(found: Sequence[LogRecord], end: int) -> List[int]:
    known = {one.number for one in found}
    last = max(end, *known, -1)
    for one in found:
        if one.kind == Kind.UNCONFIRMED:
            known.update(one.values.get("lost", []))
    return [number for number in range(last + 1) if number not in known]


def _is_behind(content: Optional[bytes], whole: bytes, least: int) -> bool:
    """Return whether kills and power cuts alone explain a file: it lacks entries at its end.

    Its first bytes, at least so many, cannot be missing. Of a line that was being added a power cut
    leaves the beginning, or zeros in its place.
    """
    rest = (content or b"").rstrip(b"\0")
    more = rest[len(whole) :]
    return len(rest) >= least and whole + more == rest + whole[len(rest) :] and b"\n" not in more


class SurveyLog:
    """Adds records to the log of a survey whose folder is locked.

    A fact costs the same however long the log is. If the log is not whole, which is both files with
    exactly the records so far, the next record that is added writes them again. No record gets the
    number of one that was lost.
    """

    def __init__(
        self, folder: Path, records: Sequence[LogRecord], whole: bool, lost: Sequence[int] = ()
    ) -> None:
        self._folder = folder
        self.is_whole = whole
        self._lost = max(lost, default=-1)
        self._records: List[LogRecord] = []
        self._notes: Set[str] = set()
        self._description: Dict[str, Any] = {}
        self._bytes = 0
        for record in records:
            self._keep(record)

    @property
    def description(self) -> Dict[str, Any]:
        return dict(self._description)

    @property
    def last(self) -> LogRecord:
        return self._records[-1]

    @property
    def records(self) -> Tuple[LogRecord, ...]:
        return tuple(self._records)

    def has_note(self, kind: Kind, values: Dict[str, Any]) -> bool:
        """Return whether the log has this note: the answer to the first request may be lost.

        A note has its own time. Other facts may come again.
        """
        return kind in NOTES and _note(kind.value, values) in self._notes

    def next(self, kind: Kind, values: Dict[str, Any], time: str) -> LogRecord:
        """Return the record that `add` would add."""
        last = self._records[-1] if self._records else None
        return LogRecord.after(last, kind, values, time, self._lost)

    def add(self, record: LogRecord) -> LogRecord:
        """Add a record of `next`; return when it is durable in both files.

        Raises:
            SurveyRefusedError: The log would become too large.
            OSError: The disk refused; the log has its former records, and the call may be
                repeated.
        """
        line = record.line()
        if record.kind not in NEEDED:
            survey_metadata.check_size(self._bytes + len(line), LOG_FILE, MAX_LOG_BYTES)
        if self.is_whole:
            self.is_whole = False
            for name in LOG_FILES:
                durable_files.append_line(self._folder / name, line)
            self.is_whole = True
        else:
            self._write([*self._records, record])
        self._keep(record)
        return record

    def take(self, record: LogRecord) -> None:
        """Add a record of `next` that `write` or the next `add` makes durable."""
        self._keep(record)
        self.is_whole = False

    def write(self) -> None:
        """Write both files again.

        Raises:
            OSError: The disk refused.
        """
        self._write(self._records)

    def write_description(self) -> None:
        """Write survey.json, for readers at a glance: nothing else depends on it.

        Raises:
            OSError: The disk refused.
        """
        content = survey_metadata.encode(self._description)
        durable_files.replace_file(self._folder / SURVEY_FILE, content)

    def _write(self, records: Sequence[LogRecord]) -> None:
        content = b"".join(one.line() for one in records)
        for name in LOG_FILES:
            durable_files.replace_file(self._folder / name, content)
        self.is_whole = True

    def _keep(self, record: LogRecord) -> None:
        self._records.append(record)
        self._bytes += len(record.line())
        add_to(self._description, record)
        if record.kind in NOTES:
            self._notes.add(_note(record.kind, record.values))


def _note(kind: str, values: Dict[str, Any]) -> str:
    return json.dumps([kind, values], sort_keys=True)
