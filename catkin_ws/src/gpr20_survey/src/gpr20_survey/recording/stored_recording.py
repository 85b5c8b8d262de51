"""The content of a recording that is already on the disk."""

from __future__ import annotations

import mmap
import os
from pathlib import Path

from gpr20_common.message import Message
from gpr20_survey.files.regular_file import open_regular


def damaged(path: Path, details: str) -> Message:
    """Return the fault of a recording that is damaged before its end."""
    return Message("{file} is damaged", file=path.name, details=details)


def mapped(path: Path) -> bytes:
    """Return the content of a file, read as it is looked at; empty if it is missing.

    Raises:
        OSError: The file cannot be read.
    """
    try:
        descriptor = open_regular(path)
    except FileNotFoundError:
        return b""
    try:
        size = os.fstat(descriptor).st_size
        # A slice of a map is bytes, which is all that the readers need.
        return mmap.mmap(descriptor, size, prot=mmap.PROT_READ) if size else b""  # type: ignore
    finally:
        os.close(descriptor)
