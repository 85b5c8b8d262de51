"""A file with one JSON object a line, to which lines are added."""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path
from typing import Any, Dict, Iterator, Mapping, Optional

from gpr20_survey.files.durable_files import ensure_folder, open_new, sync_path
from gpr20_survey.files.regular_file import read_regular


def lines_backwards(*paths: Path) -> Iterator[bytes]:
    """Yield the lines of those files that exist, the last line of the first file first."""
    for path in paths:
        with contextlib.suppress(FileNotFoundError):
            yield from reversed(read_regular(path).splitlines())


def add_line(path: Path, values: Mapping[str, Any], mode: Optional[int] = None) -> None:
    """Add an object to a file and return when it is durable.

    File and folder are made if they are missing, the file with this mode or that of its folder.

    Raises:
        OSError: The disk refused; a part of the line may be there.
        ValueError: A number is not finite.
    """
    line = json.dumps(values, allow_nan=False).encode() + b"\n"
    ensure_folder(path.parent)
    descriptor = open_new(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, mode)
    with os.fdopen(descriptor, "r+b", buffering=0) as file:
        end = file.seek(0, os.SEEK_END)
        # A line that a crash has cut is left as it is, and damages no other.
        if end and os.pread(file.fileno(), 1, end - 1) != b"\n":
            line = b"\n" + line
        if file.write(line) != len(line):
            raise OSError(f"{path}: the disk took a part of the line")
        os.fsync(file.fileno())
    sync_path(path.parent)


def object_of(line: bytes) -> Dict[str, Any]:
    """Return the object of a line; it is empty if the line has none."""
    found = None
    with contextlib.suppress(ValueError):
        found = json.loads(line)
    return found if isinstance(found, dict) else {}
