"""A survey's whole folder as one ZIP file."""

from __future__ import annotations

import contextlib
import os
import zipfile
from pathlib import Path
from typing import IO, Any, Dict, Iterator, Tuple

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_imaging import faults
from gpr20_imaging.errors import ExportFailedError, ImagingError
from gpr20_survey.files.file_sums import PIECE_BYTES, regular_files
from gpr20_survey.files.regular_file import open_regular

# The fastest: traces are text of half the size then, and sticks are slow.
LEVEL = 1


def write_zip(folder: Path, target: Any) -> None:
    """Write all files of a survey.

    Args:
        folder: The survey's folder.
        target: A file to write to.

    Raises:
        ExportFailedError: The survey changed meanwhile.
        ImagingError: A file of the survey cannot be read.
        CancelledError: The request was cancelled.
        OSError: The target cannot be written.
    """
    with _reading(folder.name):
        before = _versions(folder)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
        for name in before:
            with _reading(name):
                descriptor = open_regular(folder / name)
            with open(descriptor, "rb") as source:
                with _reading(name):
                    entry = zipfile.ZipInfo.from_file(
                        str(folder / name), f"{folder.name}/{name}", strict_timestamps=False
                    )
                entry.compress_type = zipfile.ZIP_DEFLATED
                with archive.open(entry, "w") as file:
                    for piece in _pieces(source, name):
                        file.write(piece)
    if _versions(folder) != before:
        raise ExportFailedError(
            Message("the survey was changed while it was exported; export it when it has ended"),
            fault=faults.SURVEY_CHANGES,
        )


def _pieces(source: IO[bytes], name: str) -> Iterator[bytes]:
    while True:
        with _reading(name):
            piece = source.read(PIECE_BYTES)
        if not piece:
            return
        yield piece


@contextlib.contextmanager
def _reading(name: str) -> Iterator[None]:
    """Turn an error of the survey's disk into one that does not look like one of the stick."""
    try:
        yield
    except OSError as error:
        raise ImagingError(
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
