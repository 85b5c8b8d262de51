"""The folder of what nobody but the page may read: accounts and keys."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.files.durable_files import ensure_folder, ensure_folders
from gpr20_web.errors import FolderError

MODE = 0o700


def ensure_secret_folder(folder: Path) -> None:
    """Make the folder if it is missing; let nobody but its owner into it.

    Raises:
        FolderError: It belongs to another user, who could not read what is written now; or the
            disk refused.
    """
    try:
        ensure_folders(folder.parent)
        ensure_folder(folder, MODE)
        found = folder.stat()
        if found.st_uid != os.geteuid():
            number = found.st_uid
            raise _unusable(folder, Message("it belongs to the user {number}", number=number))
        if stat.S_IMODE(found.st_mode) & 0o077:
            folder.chmod(MODE)
    except FileExistsError as error:
        if Path(error.filename).is_dir():
            # Another program has made it meanwhile.
            ensure_secret_folder(folder)
            return
        reason = OSError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), error.filename)
        raise _unusable(folder, os_reason(reason)) from error
    except OSError as error:
        if isinstance(error, FolderError):
            raise
        raise _unusable(folder, os_reason(error)) from error


def _unusable(folder: Path, reason: Message) -> FolderError:
    return FolderError(
        Message(
            "the folder of the page cannot be used: {reason}; set folder in web.yaml to one that "
            "the page may write",
            reason=reason,
            details=printable(folder),
        )
    )
