"""A whole folder as one ZIP file, in one pass."""

from __future__ import annotations

import contextlib
import os
import zipfile
from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_survey import faults
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.file_sums import regular_files
from gpr20_survey.files.regular_file import open_regular

# Small, so that who stores on this disk at the same time is not kept waiting.
PIECE_BYTES = 1 << 18


class FolderChangedError(ProcessingError):
    """A folder was changed while it was read."""

    fault = faults.FOLDER_CHANGED


class _Parts:
    """Collects what a ZIP file writes; without `tell` and `seek` it writes in one pass."""

    def __init__(self) -> None:
        self.size = 0
        self._parts: List[bytes] = []

    def write(self, data: bytes) -> int:
        """Take bytes."""
        self._parts.append(bytes(data))
        self.size += len(data)
        return len(data)

    def flush(self) -> None:
        """Do nothing: everything is here."""

    def take(self) -> bytes:
        """Return what was collected since the last time."""
        taken = b"".join(self._parts)
        self._parts, self.size = [], 0
        return taken


def zip_parts(folder: Path) -> Iterator[bytes]:
    """Yield a ZIP file of a folder as it is made, stored without compression.

    Raises:
        ProcessingError: See `add_folder`; what was yielded so far is no ZIP file.
    """
    parts: Any = _Parts()
    with zipfile.ZipFile(parts, "w", zipfile.ZIP_STORED) as archive:
        for _ in add_folder(archive, folder):
            if parts.size >= PIECE_BYTES:
                yield parts.take()
    yield parts.take()


def add_folder(archive: zipfile.ZipFile, folder: Path) -> Iterator[None]:
    """Add all files of a folder to an archive; yield after each piece of them.

    Raises:
        FolderChangedError: The folder was changed meanwhile.
        ProcessingError: A file cannot be read, or is a link.
    """
    with _reading(folder.name):
        before = _versions(folder)
    for name in before:
        with _reading(name):
            descriptor = open_regular(folder / name)
        with open(descriptor, "rb") as source:
            with _reading(name):
                entry = zipfile.ZipInfo.from_file(
                    str(folder / name), f"{folder.name}/{name}", strict_timestamps=False
                )
            entry.compress_type = archive.compression
            with archive.open(entry, "w") as file:
                while True:
                    with _reading(name):
                        piece = source.read(PIECE_BYTES)
                    if not piece:
                        break
                    file.write(piece)
                    yield
    with _reading(folder.name):
        after = _versions(folder)
    if after != before:
        raise FolderChangedError(
            Message("{folder} was changed while it was read", folder=folder.name)
        )


@contextlib.contextmanager
def _reading(name: str) -> Iterator[None]:
    """Turn an error of the disk into one that does not look like one of where the ZIP goes."""
    try:
        yield
    except OSError as error:
        raise ProcessingError(
            Message(
                "{file} of the survey cannot be read: {reason}", file=name, reason=os_reason(error)
            )
        ) from error


def _versions(folder: Path) -> Dict[str, Tuple[int, int]]:
    found = {}
    for name in regular_files(folder):
        status = os.stat(str(folder / name), follow_symlinks=False)
        found[name] = status.st_mtime_ns, status.st_size
    return found
