"""Opening files that may have been put there by something else."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from gpr20_common.message import Message
from gpr20_survey.errors import IrregularFileError

MOST_HOLE_BYTES = 64 << 20
"""A power cut may leave a hole where the last writes were [bytes]; none of them is as large."""


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
