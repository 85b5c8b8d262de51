"""Opening files that somebody else may have put there."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path


def open_regular(path: Path, follow_link: bool = False) -> int:
    """Return a descriptor for reading a file; a pipe or a device in its place is never waited for.

    Args:
        path: The file.
        follow_link: Whether the path may be a symbolic link.

    Raises:
        OSError: There is none, it is no regular file, or it cannot be read.
    """
    flags = os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK
    descriptor = os.open(str(path), flags if follow_link else flags | os.O_NOFOLLOW)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError(errno.EINVAL, "this is no ordinary file; move it away", str(path))
    return descriptor
