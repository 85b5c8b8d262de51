"""The files of a folder: their names, their checksums, and an archive of them."""

from __future__ import annotations

import hashlib
import os
import zipfile
from pathlib import Path
from typing import ContextManager, Dict, Iterator, NamedTuple, Optional, Tuple

from gpr20_common.faults import IN_USE
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import ProcessingError, storing
from gpr20_survey.files.durable_files import is_temporary
from gpr20_survey.files.regular_file import open_regular

# Small, so that who stores on this disk at the same time is not kept waiting.
PIECE_BYTES = 1 << 18


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


def add_folder(archive: zipfile.ZipFile, folder: Path) -> Iterator[None]:
    """Add all files of a folder to an archive; yield after each piece of them.

    Raises:
        ProcessingError: A file cannot be read, is a link, or the folder was changed meanwhile.
    """
    before = _versions(folder)
    for name in before:
        with _reading(folder / name):
            entry = zipfile.ZipInfo.from_file(
                str(folder / name), f"{folder.name}/{name}", strict_timestamps=False
            )
            source = open(open_regular(folder / name), "rb")  # noqa: SIM115
        entry.compress_type = archive.compression
        with source, archive.open(entry, "w") as file:
            while True:
                with _reading(folder / name):
                    piece = source.read(PIECE_BYTES)
                if not piece:
                    break
                file.write(piece)
                yield
    if _versions(folder) != before:
        raise ProcessingError(
            Message(
                "{folder} was changed while it was read; export it when its survey has ended",
                folder=folder.name,
            ),
            fault=IN_USE,
        )


def _reading(path: Path) -> ContextManager[None]:
    """Turn an error of the disk into one that does not look like one of where the ZIP goes."""
    return storing(Message("{path} could not be read", path=printable(path)), path)


def _versions(folder: Path) -> Dict[str, Tuple[int, int]]:
    with _reading(folder):
        found = {name: os.lstat(str(folder / name)) for name in regular_files(folder)}
    return {name: (one.st_mtime_ns, one.st_size) for name, one in found.items()}
