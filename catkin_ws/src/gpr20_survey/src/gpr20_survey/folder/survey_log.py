"""Adding to the log of a survey: two equal files that are only appended to.

A fact is acknowledged when its line is durable in both.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Dict, List, Sequence, Set, Tuple

from gpr20_survey.files import access, durable_files
from gpr20_survey.folder import survey_metadata
from gpr20_survey.folder.log_content import add_to
from gpr20_survey.folder.log_reading import MAX_LOG_BYTES
from gpr20_survey.folder.log_record import NOTES, Kind, LogRecord
from gpr20_survey.folder.survey_folder import LOG_FILE, LOG_FILES, SURVEY_FILE

# For the records without which a survey cannot be opened and closed.
RESERVED_BYTES = 1 << 20
NEEDED = (Kind.PLAN, Kind.RESUME, Kind.UNCONFIRMED, Kind.END)


class SurveyLog:
    """Adds records to the log of a survey whose folder is locked.

    A fact costs the same however long the log is.
    """

    def __init__(
        self, folder: Path, records: Sequence[LogRecord], whole: bool, lost: Sequence[int] = ()
    ) -> None:
        """Take the records that are right.

        Args:
            folder: The survey's folder.
            records: The records so far.
            whole: Whether both files hold exactly these; otherwise the next record that is added
                writes them again.
            lost: Numbers of records that were lost; no other record gets them.
        """
        self._folder = folder
        self._whole = whole
        self._lost = max(lost, default=-1)
        self._records: List[LogRecord] = []
        self._notes: Set[str] = set()
        self._description: Dict[str, Any] = {}
        self._bytes = 0
        for record in records:
            self._keep(record)

    @property
    def description(self) -> Dict[str, Any]:
        """What the log says of the survey."""
        return dict(self._description)

    @property
    def last(self) -> LogRecord:
        """The record that was added last."""
        return self._records[-1]

    @property
    def records(self) -> Tuple[LogRecord, ...]:
        """All records."""
        return tuple(self._records)

    @property
    def is_whole(self) -> bool:
        """Whether both files hold exactly the records."""
        return self._whole

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
            most = MAX_LOG_BYTES - RESERVED_BYTES
            survey_metadata.check_size(self._bytes + len(line), LOG_FILE, most)
        was_whole, self._whole = self._whole, False
        if was_whole:
            for name in LOG_FILES:
                _append(self._folder / name, line)
        else:
            self._write([*self._records, record])
        self._whole = True
        self._keep(record)
        return record

    def take(self, record: LogRecord) -> None:
        """Add a record of `next` that `write` or the next `add` makes durable."""
        self._keep(record)
        self._whole = False

    def write(self) -> None:
        """Write both files again.

        Raises:
            OSError: The disk refused.
        """
        self._write(self._records)
        self._whole = True

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

    def _keep(self, record: LogRecord) -> None:
        self._records.append(record)
        self._bytes += len(record.line())
        add_to(self._description, record)
        if record.kind in NOTES:
            self._notes.add(_note(record.kind, record.values))


def _note(kind: str, values: Dict[str, Any]) -> str:
    return json.dumps([kind, values], sort_keys=True)


def _append(path: Path, line: bytes) -> None:
    descriptor = access.open_new(path, os.O_RDWR | os.O_APPEND)
    try:
        if os.write(descriptor, line) != len(line):
            raise OSError(f"{path}: the disk took a part of the line")
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
