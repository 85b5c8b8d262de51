"""A new file that a library writes in memory and that reaches the disk in whole steps."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import List, Tuple

from gpr20_vna_processing.low.json_trace_file import sync_path


class CommittedFile(io.BufferedIOBase):
    """Collects writes and puts them on the disk by `commit`.

    The libraries for bag and MCAP write in many small pieces and go back to fill in
    lengths. Written straight through, a full disk or a crash leaves any mixture of them.
    Here the file on the disk only ever grows by what was collected since the last commit,
    and a commit that failed can simply be repeated: it writes the same bytes again to the
    same place.
    """

    mode = "wb"  # rosbag asks for it

    def __init__(self, path: Path, trailer: bytes = b"") -> None:
        """Create the file.

        Args:
            path: Must not exist.
            trailer: Bytes that follow the committed part on the disk without belonging to
                it; the next commit writes over them.

        Raises:
            OSError: The file exists or the disk refused.
        """
        super().__init__()
        self._trailer = trailer
        self._committed = 0  # length of what is durable [bytes]
        self._collected = bytearray()
        self._corrections: List[Tuple[int, bytes]] = []
        self._position = 0
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW
        self._descriptor = os.open(str(path), flags, 0o666)
        sync_path(path.parent)

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit [bytes]."""
        return len(self._collected)

    def writable(self) -> bool:
        """Say that the file can be written."""
        return True

    def seekable(self) -> bool:
        """Say that the position can be changed."""
        return True

    def tell(self) -> int:
        """Return the position [bytes]."""
        return self._position

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Change the position and return it [bytes]."""
        end = self._committed + len(self._collected)
        self._position = (
            offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: end}[whence]
        )
        if not 0 <= self._position <= end:
            raise ValueError(f"position {self._position} outside the {end} bytes of the file")
        return self._position

    def write(self, data) -> int:  # type: ignore[no-untyped-def]
        """Collect bytes at the position; return how many."""
        size = len(data)
        start = self._position - self._committed
        if start >= 0:
            self._collected[start : start + size] = data
        elif start + size <= 0:
            self._corrections.append((self._position, bytes(data)))
        else:
            raise ValueError("a write may not reach from the committed part into the new one")
        self._position += size
        return size

    def commit(self, first_byte_last: bool = False) -> None:
        """Write what was collected; return when it is durable.

        Args:
            first_byte_last: Whether the first byte stays zero until all behind it is
                durable, for content that must not be seen in part.

        Raises:
            OSError: The disk refused; everything collected is kept for the next commit.
        """
        if self._collected:
            data = bytes(self._collected) + self._trailer
            if first_byte_last:
                self._write_at(self._committed, b"\0" + data[1:])
                os.fsync(self._descriptor)
                data = data[:1]
            self._write_at(self._committed, data)
            os.fsync(self._descriptor)
            self._committed += len(self._collected)
            self._collected.clear()
        if self._corrections:
            # After what they point at: a header never names an index that is not there.
            for offset, data in self._corrections:
                self._write_at(offset, data)
            os.fsync(self._descriptor)
            self._corrections.clear()

    def keep_trailer(self) -> None:
        """Make the trailer that is on the disk part of the file; go on behind it without one.

        Raises:
            ValueError: Something waits for a commit.
        """
        if self._collected:
            raise ValueError("the trailer can only be kept right after a commit")
        self._committed += len(self._trailer)
        self._position = self._committed
        self._trailer = b""

    def close(self) -> None:
        """Do nothing: libraries close a file before its last commit; see `release`."""

    def release(self) -> None:
        """Close the file on the disk; what was not committed is lost."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def _write_at(self, offset: int, data: bytes) -> None:
        rest = memoryview(data)
        while rest:
            written = os.pwrite(self._descriptor, rest, offset)
            rest, offset = rest[written:], offset + written
