"""Files on a stick that have their name only when they are whole and on the stick."""

from __future__ import annotations

import contextlib
import hashlib
import os
import subprocess
from pathlib import Path
from typing import IO, Iterator

from gpr20_imaging.low.cancellation import Cancellation
from gpr20_survey.files.durable_files import put_in_place, remove_temporaries, temporary_path

PIECE_BYTES = 1 << 20
SUM = ".sha256"
# A stick of the slowest kind with all that the cache of the system may hold.
SYNC_LIMIT_S = 1800.0


class SummedFile:
    """A file that is written from its beginning to its end, and its checksum.

    It has neither `tell` nor `seek`, so that a ZIP file goes into it in one pass.

    Args:
        stream: Where the bytes go.
        cancellation: Ends the writing.
    """

    def __init__(self, stream: IO[bytes], cancellation: Cancellation) -> None:
        self._stream = stream
        self._cancellation = cancellation
        self._digest = hashlib.sha256()

    @property
    def sha256(self) -> str:
        """Checksum of what was written."""
        return self._digest.hexdigest()

    def write(self, data: bytes) -> int:
        """Write bytes.

        Raises:
            CancelledError: The request was cancelled.
            OSError: The stick refused.
        """
        self._cancellation.check()
        self._digest.update(data)
        return self._stream.write(data)

    def flush(self) -> None:
        """Pass everything to the system."""
        self._stream.flush()


@contextlib.contextmanager
def new_file(path: Path, cancellation: Cancellation) -> Iterator[SummedFile]:
    """Write a file and its checksum file; both replace older ones when the block ends.

    After an error neither has changed, and nothing unfinished is left, if the stick is still
    there.

    Raises:
        CancelledError: The request was cancelled.
        OSError: The stick refused.
    """
    sum_path = path.with_name(path.name + SUM)
    temporary, temporary_sum = temporary_path(path), temporary_path(sum_path)
    try:
        with temporary.open("xb") as stream:
            file = SummedFile(stream, cancellation)
            yield file
            _sync(stream)
        with temporary_sum.open("xb") as stream:
            stream.write(f"{file.sha256}  {path.name}\n".encode())
            _sync(stream)
        cancellation.check()
        # That of the former content must never stand beside the new one.
        with contextlib.suppress(FileNotFoundError):
            sum_path.unlink()
        put_in_place(temporary, path)
        put_in_place(temporary_sum, sum_path)
    finally:
        for one in (temporary, temporary_sum):
            # A stick that was pulled out has no files to remove; the reason is on its way already.
            with contextlib.suppress(OSError):
                one.unlink()


def copy_file(source: Path, target: SummedFile) -> None:
    """Copy the content of a file.

    Raises:
        CancelledError: The request was cancelled.
        OSError: One of them cannot be read or written.
    """
    with source.open("rb") as stream:
        for piece in iter(lambda: stream.read(PIECE_BYTES), b""):
            target.write(piece)


def make_folder(folder: Path) -> None:
    """Make a folder, if it is missing, and remove what an interrupted export left in it.

    Raises:
        OSError: The stick refused.
    """
    folder.mkdir(exist_ok=True)
    remove_temporaries(folder)


def sync_volume(folder: Path) -> None:
    """Return when everything of a volume is on it, so that the stick can be pulled out.

    Raises:
        OSError: The stick refused, or was pulled out.
    """
    try:
        subprocess.run(
            ["sync", "--file-system", str(folder)],
            stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=SYNC_LIMIT_S, check=True,
        )  # fmt: skip
    except subprocess.SubprocessError as error:
        raise OSError(str(error)) from error


def _sync(stream: IO[bytes]) -> None:
    stream.flush()
    os.fsync(stream.fileno())
