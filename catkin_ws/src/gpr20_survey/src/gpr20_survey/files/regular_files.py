"""Reading what something else may have put there: files, their checksums, folders of them."""

from __future__ import annotations

import errno
import hashlib
import os
import stat
import zipfile
from pathlib import Path
from typing import ContextManager, Dict, Iterator, NamedTuple, Optional, Tuple

from gpr20_common.faults import IN_USE
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import IrregularFileError, ProcessingError, storing

# Readers take `*.json`; a file that was never finished has neither this start nor this end.
TEMPORARY_PREFIX = "."
TEMPORARY_SUFFIX = ".tmp"
MOST_HOLE_BYTES = 64 << 20
"""A power cut may leave a hole where the last writes were [bytes]; none of them is as large."""
# Small, so that who stores on this disk at the same time is not kept waiting.
PIECE_BYTES = 1 << 18


def is_temporary(name: str) -> bool:
    """Return whether a name is that of a file which was never finished."""
    return name.startswith(TEMPORARY_PREFIX) and name.endswith(TEMPORARY_SUFFIX)


def open_regular(path: Path, follow_link: bool = False) -> int:
    """Return a descriptor for reading a file, which may be a symbolic link if that is followed.

    It never waits for a pipe or a device. A file that is mostly a hole is refused: it takes no
    space on the disk, but its zeros would be read for minutes.

    Raises:
        IrregularFileError: It is no regular file, or has a large hole.
        OSError: There is none, or it cannot be read.
    """
    # Before it is opened: that alone affects a device, or the writer of a pipe.
    _check(path, os.stat(str(path), follow_symlinks=follow_link))
    flags = os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK
    descriptor = os.open(str(path), flags if follow_link else flags | os.O_NOFOLLOW)
    try:
        size = os.fstat(descriptor).st_size
        if size > MOST_HOLE_BYTES and _has_large_hole(descriptor, size):
            raise IrregularFileError(
                Message(
                    "this has {size} bytes, but most of them were never written; move it away",
                    size=size,
                ),
                path,
            )
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def read_regular(path: Path, follow_link: bool = True) -> bytes:
    """Return the content of a file; for the arguments and errors see `open_regular`."""
    with open(open_regular(path, follow_link), "rb") as stream:
        return stream.read()


def check_regular(path: Path, follow_link: bool = False) -> None:
    """Check that a path, if there is anything, is a regular file or a folder.

    Raises:
        IrregularFileError: It is something else.
        OSError: That cannot be found out.
    """
    try:
        status = os.stat(str(path), follow_symlinks=follow_link)
    except FileNotFoundError:
        return
    if not stat.S_ISDIR(status.st_mode):
        _check(path, status)


def _check(path: Path, status: os.stat_result) -> None:
    if stat.S_ISLNK(status.st_mode):
        reason = Message("this is a symbolic link, which is not followed; move it away")
        raise IrregularFileError(reason, path)
    if not stat.S_ISREG(status.st_mode):
        raise IrregularFileError(Message("this is not a regular file; move it away"), path)


def _has_large_hole(descriptor: int, size: int) -> bool:
    """Return whether more of a file than is allowed was never written.

    File systems that do not know it say that all of a file is data.
    """
    holes = place = 0
    while place < size and holes <= MOST_HOLE_BYTES:
        hole = os.lseek(descriptor, place, os.SEEK_HOLE)
        try:
            place = os.lseek(descriptor, hole, os.SEEK_DATA)
        except OSError as error:
            if error.errno != errno.ENXIO:
                raise
            place = size  # there is no data behind the hole
        holes += place - hole
    os.lseek(descriptor, 0, os.SEEK_SET)
    return holes > MOST_HOLE_BYTES


class FileSum(NamedTuple):
    """What identifies the content of a file."""

    sha256: str
    """Hexadecimal digits."""
    size: int
    """Length [bytes]."""


def sum_of(content: bytes) -> FileSum:
    return FileSum(hashlib.sha256(content).hexdigest(), len(content))


def regular_files(folder: Path) -> Iterator[str]:
    """Yield the names of all files below a folder, relative to it and sorted.

    Links are not followed: one to a folder is a name too. What is being written is left out.
    """

    def refuse(error: OSError) -> None:
        raise error

    for parent, folders, names in os.walk(str(folder), onerror=refuse):
        folders.sort()
        below = str(Path(parent).relative_to(folder))
        links = [name for name in folders if os.path.islink(os.path.join(parent, name))]
        for name in sorted(one for one in [*names, *links] if not is_temporary(one)):
            yield os.path.normpath(os.path.join(below, name))


def sum_of_file(path: Path) -> FileSum:
    """Return the checksum of a file."""
    digest, size = hashlib.sha256(), 0
    with open(open_regular(path), "rb") as stream:
        for piece in iter(lambda: stream.read(PIECE_BYTES), b""):
            digest.update(piece)
            size += len(piece)
    return FileSum(digest.hexdigest(), size)


def sum_if_readable(path: Path) -> Optional[FileSum]:
    try:
        return sum_of_file(path)
    except OSError:
        return None


def add_folder(archive: zipfile.ZipFile, folder: Path) -> Iterator[None]:
    """Add all files of a folder to an archive; yield after each piece of them.

    Raises:
        ProcessingError: A file cannot be read, is a link, or the folder was changed meanwhile.
    """
    before = _versions(folder)
    for name in before:
        with _reading(folder / name):
            entry = zipfile.ZipInfo.from_file(
                str(folder / name), f"{folder.name}/{name}", strict_timestamps=False
            )
            source = open(open_regular(folder / name), "rb")  # noqa: SIM115
        entry.compress_type = archive.compression
        with source, archive.open(entry, "w") as file:
            while True:
                with _reading(folder / name):
                    piece = source.read(PIECE_BYTES)
                if not piece:
                    break
                file.write(piece)
                yield
    if _versions(folder) != before:
        raise ProcessingError(
            Message(
                "{folder} was changed while it was read; export it when its survey has ended",
                folder=folder.name,
            ),
            fault=IN_USE,
        )


def _reading(path: Path) -> ContextManager[None]:
    """Turn an error of the disk into one that does not look like one of where the ZIP goes."""
    return storing(Message("{path} could not be read", path=printable(path)), path)


def _versions(folder: Path) -> Dict[str, Tuple[int, int]]:
    with _reading(folder):
        found = {name: os.lstat(str(folder / name)) for name in regular_files(folder)}
    return {name: (one.st_mtime_ns, one.st_size) for name, one in found.items()}
