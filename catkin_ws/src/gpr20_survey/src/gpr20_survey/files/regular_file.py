"""Opening files that may have been put there by something else."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from gpr20_common.message import Message
from gpr20_survey.errors import IrregularFileError


def open_regular(path: Path, follow_link: bool = False) -> int:
    """Return a descriptor for reading a file; never wait for a pipe or a device.

    Args:
        path: The file.
        follow_link: Whether the path may be a symbolic link.

    Raises:
        IrregularFileError: It is no regular file.
        OSError: There is none, or it cannot be read.
    """
    flags = os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK
    try:
        descriptor = os.open(str(path), flags if follow_link else flags | os.O_NOFOLLOW)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise _link(path) from error
        if error.errno == errno.ENXIO:
            raise _irregular(path) from error
        raise
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise _irregular(path)
    return descriptor


def _link(path: Path) -> IrregularFileError:
    return IrregularFileError(
        Message("this is a symbolic link, which is not followed; move it away"), path
    )


def _irregular(path: Path) -> IrregularFileError:
    return IrregularFileError(Message("this is not a regular file; move it away"), path)
