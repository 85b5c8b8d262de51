"""Checksums of the files of a folder."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Iterator, Tuple

from gpr20_survey.files.regular_file import open_regular

PIECE_BYTES = 1 << 20


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


def sha256_and_size(path: Path) -> Tuple[str, int]:
    """Return the SHA-256 of a file, as hexadecimal digits, and its size [bytes].

    Raises:
        OSError: The file cannot be read.
    """
    digest, size = hashlib.sha256(), 0
    with open(open_regular(path), "rb") as stream:
        while True:
            piece = stream.read(PIECE_BYTES)
            if not piece:
                return digest.hexdigest(), size
            digest.update(piece)
            size += len(piece)
