"""Checksums of the files of a folder."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Iterator, NamedTuple, Optional

from gpr20_survey.files.durable_files import is_temporary
from gpr20_survey.files.regular_file import open_regular

PIECE_BYTES = 1 << 20


class FileSum(NamedTuple):
    """What identifies the content of a file."""

    sha256: str
    """Hexadecimal digits."""
    size: int
    """Length [bytes]."""


def sum_of(content: bytes) -> FileSum:
    return FileSum(hashlib.sha256(content).hexdigest(), len(content))


def regular_files(folder: Path) -> Iterator[str]:
    """Yield the names of all files below a folder, relative to it and sorted.

    Links are not followed: one to a folder is a name too. What is being written is left out.
    """

    def refuse(error: OSError) -> None:
        raise error

    for parent, folders, names in os.walk(str(folder), onerror=refuse):
        folders.sort()
        below = str(Path(parent).relative_to(folder))
        links = [name for name in folders if os.path.islink(os.path.join(parent, name))]
        for name in sorted(one for one in [*names, *links] if not is_temporary(one)):
            yield os.path.normpath(os.path.join(below, name))


def sum_of_file(path: Path) -> FileSum:
    """Return the checksum of a file."""
    digest, size = hashlib.sha256(), 0
    with open(open_regular(path), "rb") as stream:
        for piece in iter(lambda: stream.read(PIECE_BYTES), b""):
            digest.update(piece)
            size += len(piece)
    return FileSum(digest.hexdigest(), size)


def sum_if_readable(path: Path) -> Optional[FileSum]:
    try:
        return sum_of_file(path)
    except OSError:
        return None
