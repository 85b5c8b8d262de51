"""By what a data folder is known: a marker in it, and what this computer remembers of it."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Mapping, Optional

from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import printable
from gpr20_survey.files.durable_files import ensure_folders, replace_file, write_new_file
from gpr20_survey.files.regular_file import read_regular

MARKER_FILE = ".gpr20_data.json"
FORMAT = "gpr20-data/1"
MEMORY_MODE = 0o700


@dataclass(frozen=True)
class Marker:
    """What marks a data folder.

    Attributes:
        identity: UUID of the folder.
        file_system: Identity of the file system on which it was made; empty: not known.
        made: When, as the clock was then.
    """

    identity: str = field(metadata={"min_length": 1})
    file_system: str
    made: str


class DamagedRecordError(ValueError):
    """A marker, or what is remembered, is not as it was written."""


def read_marker(folder: Path) -> Optional[Marker]:
    """Return the marker of a data folder; None: it has none.

    Raises:
        DamagedRecordError: The marker is damaged.
    """
    return _read(folder / MARKER_FILE)


def write_marker(folder: Path, marker: Marker, replace: bool = False) -> None:
    """Mark a data folder; return when that is durable.

    Raises:
        FileExistsError: It has a marker, and `replace` is false.
    """
    write = replace_file if replace else write_new_file
    write(folder / MARKER_FILE, _encoded(asdict(marker)))


class FolderMemory:
    """Remembers in a folder of this computer's state which data folder was at a path."""

    def __init__(self, state: Path) -> None:
        self._folder = state / "data_folders"

    def file_of(self, path: Path) -> Path:
        """Return the file that remembers what was at a path."""
        # One for each, so that two robots never write the same file.
        return self._folder / f"{hashlib.sha256(os.fsencode(path)).hexdigest()[:32]}.json"

    def identity_at(self, path: Path) -> Optional[str]:
        """Return the identity of the data folder that was at a path; None: none was.

        Raises:
            DamagedRecordError: What is remembered is damaged.
        """
        found = _read(self.file_of(path), file_system="", made="")
        return None if found is None else found.identity

    def remember(self, path: Path, identity: str) -> None:
        """Remember the data folder at a path; return when that is durable."""
        ensure_folders(self._folder, MEMORY_MODE)
        remembered = {"identity": identity, "path": printable(path)}  # the path for people
        replace_file(self.file_of(path), _encoded(remembered))


def _encoded(values: Mapping[str, str]) -> bytes:
    return (json.dumps({"format": FORMAT, **values}, indent=2) + "\n").encode("ascii")


def _read(path: Path, **assumed: str) -> Optional[Marker]:
    try:
        content = read_regular(path, follow_link=False)
    except FileNotFoundError:
        return None
    try:
        values = json.loads(content)
        if values["format"] != FORMAT:
            raise ValueError(FORMAT)
        return record_from(Marker, {**assumed, **values}, "", others=True)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise DamagedRecordError(printable(path)) from error
