"""A file that only ever grows by whole steps, and survives a crash at any instant."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Iterable

from gpr20_survey.errors import FileReplacedError
from gpr20_survey.files.durable_files import sync_path


class CommittedFile:
    """Collects what is appended and puts it on the disk by `commit`.

    The file on the disk grows by all that was collected since the last commit, and a commit
    that failed can simply be repeated: it writes the same bytes again to the same place.
    """

    def __init__(self, path: Path, trailer: bytes = b"") -> None:
        """Create the file.

        Args:
            path: Must not exist.
            trailer: Bytes that follow the committed part on the disk without belonging to
                it; the next commit writes over them.

        Raises:
            OSError: The file exists or the disk refused.
        """
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW
        self._take(path, os.open(str(path), flags, 0o666), 0, trailer)
        sync_path(path.parent)

    @classmethod
    def resumed(cls, path: Path, length: int, trailer: bytes = b"") -> CommittedFile:
        """Go on with a file behind its first bytes; `cut` removes what follows them.

        Args:
            path: The file.
            length: How much of it is whole [bytes].
            trailer: As for a new file.

        Raises:
            OSError: The file cannot be opened.
        """
        file = cls.__new__(cls)
        flags = os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW
        file._take(path, os.open(str(path), flags), length, trailer)
        return file

    def _take(self, path: Path, descriptor: int, committed: int, trailer: bytes) -> None:
        self._path = path
        self._descriptor = descriptor
        self._trailer = trailer
        self._committed = committed  # length of what is durable [bytes]
        self._collected = bytearray()

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit [bytes]."""
        return len(self._collected)

    @property
    def committed_bytes(self) -> int:
        """How much is durable, without the trailer [bytes]."""
        return self._committed

    def in_place(self) -> bool:
        """Say whether the file that is written is still the one of its name."""
        try:
            there = os.stat(str(self._path), follow_symlinks=False)
        except OSError:
            return False
        return os.path.samestat(there, os.fstat(self._descriptor))

    def write(self, data: bytes) -> None:
        """Collect bytes behind all others."""
        self._collected += data

    def commit(self) -> None:
        """Write what was collected; return when it is durable.

        Raises:
            FileReplacedError: Somebody moved, removed or replaced the file.
            OSError: The disk refused; everything collected is kept for the next commit.
        """
        if self._collected:
            self._write_at(self._committed, bytes(self._collected) + self._trailer)
            os.fsync(self._descriptor)
            self._check_in_place()
            self._committed += len(self._collected)
            self._collected.clear()

    def cut(self) -> None:
        """Leave nothing behind the committed part but the trailer; return when it is so.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        # The trailer first: at no instant does the file end without one.
        self._write_at(self._committed, self._trailer)
        os.fsync(self._descriptor)
        os.ftruncate(self._descriptor, self._committed + len(self._trailer))
        os.fsync(self._descriptor)

    def write_tail(self, pieces: Iterable[bytes]) -> None:
        """Write the end of the file behind the trailer; return when it is durable.

        Nothing counts as committed by this, so the call may be repeated. The first byte
        stays zero until all behind it is durable: the tail is not seen in part.

        Args:
            pieces: The tail, a bounded part of it at a time; none of them is empty.

        Raises:
            OSError: The disk refused.
        """
        self._check_in_place()
        start = offset = self._committed + len(self._trailer)
        first = b""
        for piece in pieces:
            if not first:
                first, piece = piece[:1], b"\0" + piece[1:]
            self._write_at(offset, piece)
            offset += len(piece)
        os.ftruncate(self._descriptor, offset)
        os.fsync(self._descriptor)
        self.overwrite(start, first)

    def overwrite(self, offset: int, data: bytes) -> None:
        """Replace bytes in one write within a sector; return when they are durable.

        Raises:
            OSError: The disk refused.
        """
        self._write_at(offset, data)
        os.fsync(self._descriptor)

    def read_at(self, offset: int, size: int) -> bytes:
        """Return bytes of the file on the disk, fewer at its end.

        Raises:
            OSError: The disk cannot be read.
        """
        return os.pread(self._descriptor, size, offset)

    def release(self) -> None:
        """Close the file on the disk; what was not committed is lost."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def _check_in_place(self) -> None:
        if not self.in_place():
            raise FileReplacedError(
                errno.ESTALE,
                "it was moved, removed or replaced while it was written; if the survey's folder "
                "was moved or renamed, put it back, then resume the survey",
                str(self._path),
            )

    def _write_at(self, offset: int, data: bytes) -> None:
        rest = memoryview(data)
        while rest:
            written = os.pwrite(self._descriptor, rest, offset)
            rest, offset = rest[written:], offset + written
