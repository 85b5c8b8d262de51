"""Opening files that somebody else may have put there."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from gpr20_survey.errors import IrregularFileError

LINK = "this is a symbolic link, which is not followed; move it away"
STRANGE = "this is no ordinary file; move it away"


def open_regular(path: Path, follow_link: bool = False) -> int:
    """Return a descriptor for reading a file; a pipe or a device in its place is never waited for.

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
            raise _irregular(path, LINK) from error
        if error.errno == errno.ENXIO:
            raise _irregular(path, STRANGE) from error
        raise
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise _irregular(path, STRANGE)
    return descriptor


def _irregular(path: Path, reason: str) -> IrregularFileError:
    return IrregularFileError(errno.EINVAL, reason, str(path))
