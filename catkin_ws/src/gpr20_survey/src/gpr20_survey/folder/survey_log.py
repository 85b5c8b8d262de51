"""The log of a survey: log.jsonl, and survey.json, which holds the same records.

A fact is acknowledged when both are durable.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Callable, Dict, Sequence, Tuple

from gpr20_survey.files import access, durable_files
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.log_content import description_of, view_of
from gpr20_survey.folder.log_reading import MAX_LOG_BYTES
from gpr20_survey.folder.log_record import Kind, LogRecord

# For the records without which a survey cannot be opened and closed.
RESERVED_BYTES = 1 << 20
NEEDED = (Kind.PLAN, Kind.RESUME, Kind.UNCONFIRMED, Kind.END)


class SurveyLog:
    """Adds records to the log of a survey whose folder is locked."""

    def __init__(
        self, folder: Path, records: Sequence[LogRecord], whole: bool, lost: Sequence[int] = ()
    ) -> None:
        """Take the records that are right.

        Args:
            folder: The survey's folder.
            records: The records so far.
            whole: Whether log.jsonl holds exactly these; otherwise the next record that is added
                writes it again.
            lost: Numbers of records that were lost; no other record gets them.
        """
        self._path = folder / survey_folder.LOG_FILE
        self._view = folder / survey_folder.SURVEY_FILE
        self._records = list(records)
        self._whole = whole
        self._lost = max(lost, default=-1)

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
        last = self._records[-1] if self._records else None
        return LogRecord.after(last, kind, values, time, self._lost)

    def add(self, record: LogRecord) -> LogRecord:
        """Add a record of `next`; return when it is durable in both files.

        Raises:
            SurveyRefusedError: The log would become too large.
            OSError: The disk refused; the log has its former records, and the call may be
                repeated.
        """
        records = [*self._records, record]
        view = view_of(records)
        self._check_room(record, view)
        was_whole, self._whole = self._whole, False
        if was_whole:
            _append(self._path, record.line())
        else:
            durable_files.replace_file(self._path, b"".join(one.line() for one in records))
        durable_files.replace_file(self._view, view)
        self._records, self._whole = records, True
        return record

    def _check_room(self, record: LogRecord, view: bytes) -> None:
        if record.kind in NEEDED:
            return
        size = self._path.stat().st_size if self._whole else 0
        for path, bytes_, most in (
            (self._path, size + len(record.line()), MAX_LOG_BYTES),
            (self._view, len(view), survey_metadata.MAX_FILE_BYTES),
        ):
            survey_metadata.check_size(bytes_, path.name, most - RESERVED_BYTES)

    @property
    def is_whole(self) -> bool:
        """Whether both files hold exactly the records."""
        return self._whole

    def take(self, record: LogRecord) -> None:
        """Add a record of `next` that `write`, which must follow, makes durable."""
        self._records.append(record)
        self._whole = False

    def write(self, on_log: Callable[[], None] = lambda: None) -> None:
        """Write both files again.

        Args:
            on_log: Called when log.jsonl is durable, before survey.json is written.

        Raises:
            OSError: The disk refused.
        """
        durable_files.replace_file(self._path, b"".join(one.line() for one in self._records))
        on_log()
        durable_files.replace_file(self._view, view_of(self._records))
        self._whole = True


def _append(path: Path, line: bytes) -> None:
    descriptor = access.open_new(path, os.O_RDWR | os.O_APPEND)
    try:
        if os.write(descriptor, line) != len(line):
            raise OSError(f"{path}: the disk took a part of the line")
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
