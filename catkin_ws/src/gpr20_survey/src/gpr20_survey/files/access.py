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
    """Return the descriptor of a file that is made if it is missing.

    Args:
        path: The file.
        flags: As for `os.open`; with O_EXCL the file must not exist.
        mode: Its mode; None: that of its folder.

    Raises:
        OSError: The disk refused.
    """
    made = bool(flags & os.O_CREAT)
    if mode is None:
        mode = file_mode_for(path.parent)
    descriptor = os.open(str(path), flags | os.O_CLOEXEC | os.O_NOFOLLOW, mode)
    try:
        if made and stat.S_IMODE(os.fstat(descriptor).st_mode) != mode:
            os.fchmod(descriptor, mode)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def make_folder(path: Path, mode: int) -> None:
    """Make a folder that must not exist yet.

    Args:
        path: The folder.
        mode: Its mode; a group that it inherits from the folder above is kept.

    Raises:
        FileExistsError: The folder exists.
        OSError: The disk refused.
    """
    path.mkdir(mode)
    made = stat.S_IMODE(path.stat().st_mode)
    if made & 0o777 != mode & 0o777:
        path.chmod(mode & 0o777 | made & stat.S_ISGID)


def mode_for(folder: Path) -> int:
    """Return the mode of a new folder in another one: that of the other."""
    return _mode_of(folder) & FOLDER_MODES


def file_mode_for(folder: Path) -> int:
    """Return the mode of a new file in a folder."""
    return _mode_of(folder) & FILE_MODES


def _mode_of(folder: Path) -> int:
    return stat.S_IMODE(folder.stat().st_mode)
