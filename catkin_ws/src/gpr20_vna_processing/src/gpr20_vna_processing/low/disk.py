"""The disk below the data folder."""

from __future__ import annotations

import shutil
from pathlib import Path


def free_bytes(folder: Path) -> int:
    """Return what may still be written below the folder [bytes].

    Raises:
        OSError: The folder cannot be asked.
    """
    return shutil.disk_usage(str(folder)).free
