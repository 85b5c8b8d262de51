"""A survey's whole folder as one ZIP file."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any, Dict, Tuple

from gpr20_common.message import Message
from gpr20_imaging import faults
from gpr20_imaging.errors import ExportFailedError
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
        CancelledError: The request was cancelled.
        OSError: A file cannot be read, or the target not be written.
    """
    before = _versions(folder)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
        for name in before:
            path = folder / name
            entry = zipfile.ZipInfo.from_file(
                str(path), f"{folder.name}/{name}", strict_timestamps=False
            )
            entry.compress_type = zipfile.ZIP_DEFLATED
            with open(open_regular(path), "rb") as source, archive.open(entry, "w") as file:
                for piece in iter(lambda: source.read(PIECE_BYTES), b""):
                    file.write(piece)
    if _versions(folder) != before:
        raise ExportFailedError(
            Message("the survey was changed while it was exported; export it when it has ended"),
            fault=faults.SURVEY_CHANGES,
        )


def _versions(folder: Path) -> Dict[str, Tuple[int, int]]:
    found = {}
    for name in regular_files(folder):
        status = (folder / name).stat()
        found[name] = status.st_mtime_ns, status.st_size
    return found
