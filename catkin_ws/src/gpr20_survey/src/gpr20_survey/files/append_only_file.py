"""A file that only grows, by whole commits, and survives a crash at any instant."""

from __future__ import annotations

import os
from pathlib import Path

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.errors import IrregularFileError
from gpr20_survey.files.durable_files import open_new, put_in_place, sync_path


class AppendOnlyFile:
    """Collects what is appended to a new file and puts it on the disk by `commit`.

    The file on the disk grows by all that was collected since the last commit, and a commit
    that failed can simply be repeated: it writes the same bytes again to the same place.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._committed = 0  # length of what was written [bytes]
        self._collected = bytearray()
        self._descriptor = open_new(path, os.O_CREAT | os.O_EXCL | os.O_RDWR)
        sync_path(path.parent)

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit [bytes]."""
        return len(self._collected)

    def write(self, data: bytes) -> int:
        """Collect bytes behind all others; return how many."""
        self._collected += data
        return len(data)

    def tell(self) -> int:
        """Return where the next byte goes [bytes]."""
        return self._committed + len(self._collected)

    def flush(self) -> None:
        """Do nothing: only `commit` writes to the disk."""

    def in_place(self) -> bool:
        """Return whether the file that is written still has its name."""
        try:
            there = os.stat(str(self.path), follow_symlinks=False)
        except OSError:
            return False
        return os.path.samestat(there, os.fstat(self._descriptor))

    def take_place_of(self, path: Path) -> None:
        """Give the file the name of another, which it replaces; return when that is durable."""
        put_in_place(self.path, path)
        self.path = path

    def commit(self) -> None:
        """Write what was collected; return when it is durable.

        Raises:
            IrregularFileError: The file was moved, removed or replaced.
            OSError: The disk refused; everything collected remains for the next commit.
        """
        if not self._collected:
            return
        offset, rest = self._committed, memoryview(bytes(self._collected))
        while rest:
            written = os.pwrite(self._descriptor, rest, offset)
            rest, offset = rest[written:], offset + written
        os.fsync(self._descriptor)
        if not self.in_place():
            raise IrregularFileError(
                Message(
                    "it was moved, removed or replaced while it was written; if the survey's "
                    "folder was moved or renamed, put it back, then resume the survey",
                ),
                self.path,
                fault=faults.FOLDER_MOVED,
            )
        self._committed = offset
        self._collected.clear()

    def release(self) -> None:
        """Close the file on the disk; what was not committed is lost."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
