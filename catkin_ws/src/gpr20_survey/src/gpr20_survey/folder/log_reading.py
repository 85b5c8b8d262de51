"""Reading the log of a survey from its two files, of which each repairs the other.

A line judges itself by its checksum, and names that of the line before it. It is taken from the
file in which it is whole; what is whole in neither file is lost, and named.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_metadata
from gpr20_survey.folder.log_record import NO_RECORD, Kind, LogHead, LogRecord, record_of_line
from gpr20_survey.folder.survey_folder import LOG_FILES

MAX_LOG_BYTES = 64 << 20
MAX_SHOWN_CHARACTERS = 10_000  # of one record
MAX_ALL_CHARACTERS = 250_000
MAX_NAMED = 1000
# How a record begins and ends in its line.
_ANY = b'{"number":'
_NUMBER = re.compile(rb'\{"number":(\d{1,7}),')
_BEGIN = re.compile(rb'\{"number":\d+,"time":"')
_END = re.compile(rb'"sha256":"[0-9a-f]{64}"\}')


@dataclass(frozen=True)
class FoundLog:
    """What a folder holds of its survey's log.

    Attributes:
        records: Those that are right, in their order.
        lost: Numbers of records that neither file holds and that no record names as lost.
        strangers: Records with a right checksum that are not of the log of the others.
        damaged: Names of the files that are damaged or missing.
        behind: Names of the files that lack the last record, as after a power cut while it was
            added.
        unreadable: The lines that are no records.
    """

    records: Tuple[LogRecord, ...] = ()
    lost: Tuple[int, ...] = ()
    strangers: Tuple[LogRecord, ...] = ()
    damaged: Tuple[str, ...] = ()
    behind: Tuple[str, ...] = ()
    unreadable: Sequence[bytes] = field(default=(), repr=False)

    @property
    def is_whole(self) -> bool:
        """Whether both files are as they were written."""
        return not (self.damaged or self.behind or self.lost)

    def lost_entries(self) -> Dict[str, Any]:
        """Return what a record must name of what is lost, for ever; it is not used.

        Whatever can be read of it stands beside it.
        """
        reason = "its checksum is wrong in both files of the log, or it is missing"
        if len(self.lost) > MAX_NAMED:
            return {f"{len(self.lost)} records from {self.lost[0]} on": {"reason": reason}}
        texts = _texts(self.unreadable)
        entries = {
            f"record {number}": {"reason": reason, "found": texts.get(number, [])}
            for number in self.lost
        }
        for one in self.strangers[:MAX_NAMED]:
            entries[f"record {one.number}, {one.sha256[:8]}"] = {
                "reason": "it is not of the log of the other records",
                "found": [_shown(one.line()[:-1])],
            }
        return entries


class _Form(NamedTuple):
    """One of the two files."""

    records: Mapping[int, LogRecord]
    unreadable: List[bytes]
    end: int
    """Number of the last record that there was, although it may be damaged."""
    is_torn: bool
    """Whether it ends within a line."""

    @property
    def is_sound(self) -> bool:
        """Whether it ends with a whole line, and has no other ones."""
        return bool(self.records) and not self.unreadable and not self.is_torn

    def is_strange(self, folder: str, sealed: Optional[LogHead]) -> Tuple[bool, bool]:
        """Return whether it lacks what the manifest names; whether it is of another survey."""
        survey = self.records[0].values.get("survey_id") if 0 in self.records else None
        has_sealed = sealed is not None and sealed in map(LogHead.of, self.records.values())
        return not has_sealed, not folder.endswith(f"_{str(survey)[:8]}")


def read_log(folder: Path, sealed: Optional[LogHead] = None) -> FoundLog:
    """Return the log of a survey; nothing is changed.

    Args:
        folder: The survey's folder.
        sealed: A record that the log had, by its manifest.
    """
    contents = [_content(folder / name) for name in LOG_FILES]
    first = _form(contents[0] or b"")
    forms = [first, first if contents[1] == contents[0] else _form(contents[1] or b"")]
    # Where the files are two logs, the one that belongs here is read.
    forms.sort(key=lambda one: one.is_strange(folder.name, sealed))
    found = _merged(forms, sealed)
    ends = [-1 if sealed is None else sealed.number]
    for own, other in (forms, forms[::-1]):
        # Of a line that was torn while it was added nothing was acknowledged, if the other file,
        # which a power cut leaves alone, shows that it was.
        ends.append(own.end + (own.is_torn and not other.is_sound))
    lines = [one.line() for one in found]
    lost = tuple(_lost_numbers(found, max(ends)))
    lacks = {name: _lacks(one, lines) for name, one in zip(LOG_FILES, contents)}
    # Where something is lost, a torn end is no trace of a power cut.
    behind = () if lost else tuple(name for name, count in lacks.items() if count == 1)
    return FoundLog(
        tuple(found),
        lost,
        _strangers(found, forms),
        tuple(name for name, count in lacks.items() if count and name not in behind),
        behind,
        [line for form in forms for line in form.unreadable],
    )


def _content(path: Path) -> Optional[bytes]:
    """Return the content of a file; None if it cannot be read."""
    try:
        with open(open_regular(path), "rb") as stream:
            # Before it is read, so that a huge file takes no memory.
            survey_metadata.check_size(os.fstat(stream.fileno()).st_size, path.name, MAX_LOG_BYTES)
            return stream.read()
    except (OSError, SurveyRefusedError):
        return None


def _form(content: bytes) -> _Form:
    *lines, tail = content.split(b"\n")
    records: Dict[int, LogRecord] = {}
    unreadable: List[bytes] = []
    behind: List[bytes] = []
    for line in filter(None, lines):
        record = record_of_line(line)
        if record is None:
            behind.append(line)
        else:
            records.setdefault(record.number, record)
            unreadable += behind
            behind = []
    last = record_of_line(tail) if tail else None
    if last is not None:
        records.setdefault(last.number, last)
    # A changed byte may have made two lines of one, or one of two.
    begun, ended = (len(one.findall(b"\n".join(behind))) for one in (_BEGIN, _END))
    end = max(records, default=-1) + max(begun, ended, min(1, len(behind)))
    is_torn = last is None and bool(tail.strip(b"\0"))
    return _Form(records, [*unreadable, *behind], end, is_torn)


def _merged(forms: Sequence[_Form], sealed: Optional[LogHead]) -> List[LogRecord]:
    """Return the record of each number that is right, and follows the one before it."""
    numbers = sorted({number for form in forms for number in form.records})
    named = {
        LogHead(number - 1, record.previous)
        for form in forms
        for number, record in form.records.items()
    }
    found: List[LogRecord] = []
    for number in numbers:
        candidates = [form.records[number] for form in forms if number in form.records]
        # Where the files contradict each other, the record that something else names is right.
        candidates.sort(key=lambda one: (LogHead.of(one) != sealed, LogHead.of(one) not in named))
        fitting = [one for one in candidates if _follows(found, one)]
        found += fitting[:1]
    return found


def _follows(found: Sequence[LogRecord], record: LogRecord) -> bool:
    if record.number == 0:
        return record.previous == NO_RECORD
    last = found[-1] if found else None
    # Behind a lost record nothing but its own checksum vouches for a record.
    return last is None or last.number < record.number - 1 or last.sha256 == record.previous


def _strangers(found: Sequence[LogRecord], forms: Sequence[_Form]) -> Tuple[LogRecord, ...]:
    used = set(map(LogHead.of, found))
    others = {LogHead.of(one): one for form in forms for one in form.records.values()}
    return tuple(others[key] for key in sorted(others.keys() - used))


def _lost_numbers(found: Sequence[LogRecord], end: int) -> List[int]:
    present = {one.number for one in found}
    named = {
        number
        for one in found
        if one.kind == Kind.UNCONFIRMED.value
        for number in one.values.get("lost", [])
    }
    last = max(end, found[-1].number if found else -1)
    return [number for number in range(last + 1) if number not in present | named]


def _lacks(content: Optional[bytes], lines: Sequence[bytes]) -> int:
    """Return how many of the last lines a file lacks: none, or one; -1: it is damaged."""
    if content is None:
        return -1
    whole = b"".join(lines)
    if content == whole:
        return 0
    # What a power cut leaves of a line is its beginning, or zeros in its place.
    last = lines[-1] if lines else b""
    before = whole[: len(whole) - len(last)]
    if content.startswith(before) and _is_beginning(content[len(before) :], last):
        return 1
    is_behind = content.startswith(whole) and _is_beginning(content[len(whole) :], _ANY)
    return 1 if is_behind else -1


def _is_beginning(torn: bytes, line: bytes) -> bool:
    known = min(len(torn), len(_ANY)) if line is _ANY else len(torn)
    return b"\n" not in torn and (line.startswith(torn[:known]) or not torn.strip(b"\0"))


def _texts(lines: Sequence[bytes]) -> Dict[int, List[str]]:
    """Return damaged lines as texts, by the numbers with which they begin."""
    texts: Dict[int, List[str]] = {}
    characters = 0
    for line in dict.fromkeys(lines):
        begin = _NUMBER.match(line)
        if begin is not None and characters < MAX_ALL_CHARACTERS:
            text = _shown(line)
            characters += len(text)
            texts.setdefault(int(begin.group(1)), []).append(text)
    return texts


def _shown(line: bytes) -> str:
    """Return a line as text: nothing of it may be taken for an entry."""
    return line[:MAX_SHOWN_CHARACTERS].decode("ascii", "backslashreplace")
