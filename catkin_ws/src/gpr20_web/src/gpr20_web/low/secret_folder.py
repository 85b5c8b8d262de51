"""The folder of what nobody but the page may read: accounts, key, audit."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from gpr20_survey.files.durable_files import ensure_folder, ensure_folders

MODE = 0o700


def ensure_secret_folder(folder: Path) -> None:
    """Make the folder if it is missing; let nobody but its owner into it.

    Raises:
        PermissionError: It belongs to another user, who could not read what is written now.
        OSError: The disk refused.
    """
    ensure_folders(folder.parent)
    ensure_folder(folder, MODE)
    found = folder.stat()
    if found.st_uid != os.geteuid():
        raise PermissionError(f"{folder} belongs to the user with the number {found.st_uid}")
    if stat.S_IMODE(found.st_mode) & 0o077:
        folder.chmod(MODE)
