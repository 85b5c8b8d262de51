"""Files on a stick that have their name only when they are whole and on the stick.

The mount point and the folder of the exports are opened once, without following links, and
everything else is named relative to them: what is put there meanwhile, or instead of the stick,
leads to no other disk.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import secrets
import stat
import subprocess
from pathlib import Path
from typing import IO, Callable, Dict, Iterator

from gpr20_common.message import Message
from gpr20_imaging import faults
from gpr20_imaging.errors import ExportFailedError
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_survey.results.volume import Volume

PIECE_BYTES = 1 << 20
SUM = ".sha256"
# A stick of the slowest kind with all that the cache of the system may hold.
SYNC_LIMIT_S = 1800.0
FOLDER_FLAGS = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
NEW_FILE_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
OLD_FILE_FLAGS = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
# What is being written, until it has its name.
TEMPORARY = re.compile(r"\.(?P<name>.+?)(\.sha256)?\.[0-9a-f]{8}\.tmp")


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


def copy_file(source: Path, target: SummedFile) -> None:
    """Copy the content of a file.

    Raises:
        CancelledError: The request was cancelled.
        OSError: One of them cannot be read or written.
    """
    with source.open("rb") as stream:
        for piece in iter(lambda: stream.read(PIECE_BYTES), b""):
            target.write(piece)


class StickFolder:
    """The folder of the exports on a stick; a context that closes it.

    Args:
        volume: The stick.
        name: Of the folder, which is made if it is missing.

    Raises:
        ExportFailedError: The stick was removed, or something else has the name.
        OSError: The stick refused.
    """

    def __init__(self, volume: Volume, name: str) -> None:
        self._volume, self._name = volume, name
        self._sums: Dict[str, str] = {}  # SHA-256 of each file that has its name
        with contextlib.ExitStack() as opened:
            self._root = os.open(volume.path, FOLDER_FLAGS)
            opened.callback(os.close, self._root)
            if os.fstat(self._root).st_dev != volume.device:
                raise self._gone()
            with contextlib.suppress(FileExistsError):
                os.mkdir(name, dir_fd=self._root)
            self._check_folder(os.stat(name, dir_fd=self._root, follow_symlinks=False))
            self._folder = os.open(name, FOLDER_FLAGS, dir_fd=self._root)
            opened.callback(os.close, self._folder)
            self._check_folder(os.fstat(self._folder))
            self._opened = opened.pop_all()

    def __enter__(self) -> StickFolder:
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def remove_unfinished(self, is_own: Callable[[str], bool]) -> None:
        """Remove what an interrupted export left.

        Args:
            is_own: Whether a name is that of a finished export. Whatever else looks unfinished
                was left by another program, and stays.

        Raises:
            OSError: The stick refused.
        """
        for name in os.listdir(self._folder):
            found = TEMPORARY.fullmatch(name)
            if found is None or not is_own(found["name"]):
                continue
            if stat.S_ISREG(os.stat(name, dir_fd=self._folder, follow_symlinks=False).st_mode):
                os.unlink(name, dir_fd=self._folder)

    @contextlib.contextmanager
    def new_file(self, name: str, cancellation: Cancellation) -> Iterator[SummedFile]:
        """Write a file and its checksum file; both replace older ones when the block ends.

        After an error neither has changed, and nothing unfinished is left, if the stick is still
        there.

        Raises:
            CancelledError: The request was cancelled.
            OSError: The stick refused.
        """
        temporary, temporary_sum = _temporary(name), _temporary(name + SUM)
        try:
            with self._new(temporary) as stream:
                file = SummedFile(stream, cancellation)
                yield file
                _sync(stream)
            line = f"{file.sha256}  {name}\n".encode()
            with self._new(temporary_sum) as stream:
                stream.write(line)
                _sync(stream)
            cancellation.check()
            # That of the former content must never stand beside the new one.
            with contextlib.suppress(FileNotFoundError):
                os.unlink(name + SUM, dir_fd=self._folder)
            self._put(temporary, name)
            self._put(temporary_sum, name + SUM)
            self._sums[name] = file.sha256
            self._sums[name + SUM] = hashlib.sha256(line).hexdigest()
        finally:
            for one in (temporary, temporary_sum):
                # A stick that was pulled out has no files to remove; the reason is on its way
                # already.
                with contextlib.suppress(OSError):
                    os.unlink(one, dir_fd=self._folder)

    def sync(self) -> None:
        """Return when everything of the stick is on it, so that it can be pulled out.

        Raises:
            OSError: The stick refused, or was pulled out.
        """
        try:
            subprocess.run(
                ["sync", "--file-system", f"/proc/self/fd/{self._folder}"],
                stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=SYNC_LIMIT_S, check=True,
                pass_fds=[self._folder],
            )  # fmt: skip
        except subprocess.SubprocessError as error:
            raise OSError(str(error)) from error

    def check_in_place(self) -> None:
        """Check that the stick and the folder still have their names.

        Raises:
            ExportFailedError: Something else has one of them.
            OSError: The stick was removed.
        """
        if not _is_same(os.stat(self._volume.path, follow_symlinks=False), self._root):
            raise self._gone()
        there = os.stat(self._name, dir_fd=self._root, follow_symlinks=False)
        if not _is_same(there, self._folder):
            raise self._no_folder()

    def check_written(self, cancellation: Cancellation) -> None:
        """Read all that was written from the stick and compare it; `sync` must have returned.

        Raises:
            ExportFailedError: The stick does not hold it.
            CancelledError: The request was cancelled.
            OSError: A file cannot be read.
        """
        for name, expected in self._sums.items():
            with open(os.open(name, OLD_FILE_FLAGS, dir_fd=self._folder), "rb") as stream:
                if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                    raise self._differs(name)
                # What the system still has in memory would say nothing about the stick.
                os.posix_fadvise(stream.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
                digest = hashlib.sha256()
                for piece in iter(lambda: stream.read(PIECE_BYTES), b""):
                    cancellation.check()
                    digest.update(piece)
            if digest.hexdigest() != expected:
                raise self._differs(name)

    def _new(self, name: str) -> IO[bytes]:
        return open(os.open(name, NEW_FILE_FLAGS, 0o666, dir_fd=self._folder), "wb")

    def _put(self, temporary: str, name: str) -> None:
        os.replace(temporary, name, src_dir_fd=self._folder, dst_dir_fd=self._folder)
        os.fsync(self._folder)

    def _check_folder(self, status: os.stat_result) -> None:
        if not stat.S_ISDIR(status.st_mode) or status.st_dev != self._volume.device:
            raise self._no_folder()

    def _gone(self) -> ExportFailedError:
        return ExportFailedError(
            Message("the USB stick at {path} was replaced by another one", path=self._volume.path),
            fault=faults.STICK,
        )

    def _no_folder(self) -> ExportFailedError:
        return ExportFailedError(
            Message(
                "{folder} on the USB stick {name} is a link, a file or another disk, not a folder "
                "of the stick; rename it",
                folder=self._name,
                name=self._volume.name,
            ),
            fault=faults.STICK,
        )

    def _differs(self, name: str) -> ExportFailedError:
        return ExportFailedError(
            Message(
                "the USB stick {name} does not hold what was written to {file}; do not rely on it",
                name=self._volume.name,
                file=name,
            )
        )


def _temporary(name: str) -> str:
    return f".{name}.{secrets.token_hex(4)}.tmp"


def _is_same(there: os.stat_result, descriptor: int) -> bool:
    return os.path.samestat(there, os.fstat(descriptor))


def _sync(stream: IO[bytes]) -> None:
    stream.flush()
    os.fsync(stream.fileno())
