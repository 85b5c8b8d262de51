"""Who may read what is stored.

The folder of a survey is made with the mode that the robot's parameters give. Whatever is made in
a folder later follows that folder, so a survey's files always have one mode, also when it is
resumed with other parameters. The umask has no influence.
"""

from __future__ import annotations

import enum
import os
import stat
from pathlib import Path
from typing import Optional

# What may be taken over from a folder: never the right of everyone to write.
FILE_MODES, FOLDER_MODES = 0o664, 0o775


class Readers(enum.Enum):
    """Who may read a survey; only its owner may write."""

    OWNER = "owner"
    GROUP = "group"
    ALL = "all"

    @property
    def folder_mode(self) -> int:
        """Mode of a folder."""
        return {Readers.OWNER: 0o700, Readers.GROUP: 0o750, Readers.ALL: 0o755}[self]


def open_new(path: Path, flags: int, mode: Optional[int] = None) -> int:
    """Return the descriptor of a file that is made, with O_CREAT among the flags, if it is missing.

    Its mode is that of its folder, if none is given.
    """
    mode = file_mode_for(path.parent) if mode is None else mode
    descriptor = os.open(str(path), flags | os.O_CLOEXEC | os.O_NOFOLLOW, mode)
    try:
        if flags & os.O_CREAT and stat.S_IMODE(os.fstat(descriptor).st_mode) != mode:
            os.fchmod(descriptor, mode)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def file_mode_for(folder: Path) -> int:
    """Return the mode of a new file in a folder."""
    return folder.stat().st_mode & FILE_MODES
