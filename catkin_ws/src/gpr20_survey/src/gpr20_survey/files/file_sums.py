"""Checksums of the files of a folder."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Iterator, NamedTuple, Optional

from gpr20_survey.files.regular_file import open_regular

PIECE_BYTES = 1 << 20


class FileSum(NamedTuple):
    """What identifies the content of a file."""

    sha256: str
    """Hexadecimal digits."""
    size: int
    """Length [bytes]."""


def sum_of(content: bytes) -> FileSum:
    """Return the checksum of a file that has this content."""
    return FileSum(hashlib.sha256(content).hexdigest(), len(content))


def regular_files(folder: Path) -> Iterator[str]:
    """Yield the names of all files below a folder, relative to it and sorted.

    Raises:
        OSError: The folder cannot be read.
    """

    def refuse(error: OSError) -> None:
        raise error

    for parent, folders, names in os.walk(str(folder), onerror=refuse):
        folders.sort()
        for name in sorted(names):
            yield (Path(parent) / name).relative_to(folder).as_posix()


def sum_of_file(path: Path) -> FileSum:
    """Return the checksum of a file.

    Raises:
        OSError: The file cannot be read.
    """
    digest, size = hashlib.sha256(), 0
    with open(open_regular(path), "rb") as stream:
        while True:
            piece = stream.read(PIECE_BYTES)
            if not piece:
                return FileSum(digest.hexdigest(), size)
            digest.update(piece)
            size += len(piece)


def sum_if_readable(path: Path) -> Optional[FileSum]:
    """Return the checksum of a file; None if it cannot be read."""
    try:
        return sum_of_file(path)
    except OSError:
        return None
