"""A whole folder as one ZIP file, in one pass."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import ContextManager, Dict, Iterator, Tuple

from gpr20_common.faults import IN_USE
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import ProcessingError, storing
from gpr20_survey.files.file_sums import regular_files
from gpr20_survey.files.regular_file import open_regular

# Small, so that who stores on this disk at the same time is not kept waiting.
PIECE_BYTES = 1 << 18


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
