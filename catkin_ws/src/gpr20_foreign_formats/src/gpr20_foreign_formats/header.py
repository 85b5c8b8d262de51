"""The headers of other instruments' files, with checks, and the bytes behind them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, List, Mapping

import numpy as np

from gpr20_analysis import faults, lazy
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.message import Message
from gpr20_survey.files.regular_file import check_regular, read_regular

BYTES_PER_SAMPLE = 40.0  # in memory: as stored, in double precision, complex, and on the grid
SHOWN = 80


@dataclass(frozen=True)
class Header:
    """The entries of a header: numbers, or texts that should be numbers; of a file by this name.

    If `typed`, a text, true and false are no numbers.
    """

    file: str
    entries: Mapping[str, Any]
    typed: bool = False

    def refused(self, key: str, allowed: Message) -> UnreadableFileError:
        """Return the error for an entry."""
        text = Message(
            "{file}: {key} is {found}; it must be {allowed}. Give the right file or option",
            file=self.file,
            key=key,
            found=str(self.entries.get(key, "-"))[:SHOWN],
            allowed=allowed,
        )
        return UnreadableFileError(text, fault=faults.INPUT)

    def number(self, key: str, lowest: float, highest: float, default: object = None) -> float:
        """Return a number; the default if there is no such entry.

        Raises:
            UnreadableFileError: It is missing, no number, or out of range.
        """
        found, limits = self.entries.get(key, default), {"lowest": lowest, "highest": highest}
        if self.typed and np.asarray(found).dtype.kind not in "iuf":
            allowed = Message("a number, no text, between {lowest:g} and {highest:g}", **limits)
            raise self.refused(key, allowed)
        try:
            value = float(found)
        except (TypeError, ValueError):
            value = float("nan")
        # Written so that NaN is refused too.
        if not lowest <= value <= highest:
            raise self.refused(key, Message("between {lowest:g} and {highest:g}", **limits))
        return value

    def count(self, key: str, lowest: int, highest: int) -> int:
        """Return a whole number, see `number`."""
        value = self.number(key, lowest, highest)
        if value != int(value):
            raise self.refused(key, Message("a whole number"))
        return int(value)


def text_header(path: Path, separator: str) -> Header:
    """Return a text header with an entry in each line; names are in capitals.

    Raises:
        OSError: It cannot be read.
    """
    lines = content_of(path).decode("latin-1").splitlines()
    pairs = (line.partition(separator) for line in lines)
    found = {" ".join(key.upper().split()): value.strip() for key, _, value in pairs}
    return Header(path.name, found)


def content_of(path: Path) -> bytes:
    """Return the bytes of a file, if its samples fit into the memory.

    Raises:
        TooLargeError: They do not fit.
        OSError: It cannot be read.
    """
    check_regular(path, follow_link=True)
    purpose = Message("reading {file}", file=path.name)
    lazy.require_bytes(BYTES_PER_SAMPLE * path.stat().st_size, purpose)
    return read_regular(path)


def trace_count(path: Path, size: int, trace_bytes: int) -> int:
    """Return how many traces are in the bytes behind the header.

    Raises:
        UnreadableFileError: There is none, or the last one is not whole.
    """
    count, rest = divmod(size, trace_bytes)
    if count < 1 or rest:
        raise UnreadableFileError(
            Message(
                "{file} has {size} bytes of traces, but a trace has {trace_bytes} bytes by its "
                "header: the file was cut off, or its header is damaged",
                file=path.name,
                size=size,
                trace_bytes=trace_bytes,
            )
        )
    return count


def siblings(path: Path, *endings: str) -> List[Path]:
    """Return the files of the same name with one of these endings, in small letters or capitals."""
    wanted = {path.stem.lower() + one for one in endings}
    return sorted(one for one in path.parent.iterdir() if one.name.lower() in wanted)


def sibling(path: Path, *endings: str) -> Path:
    """Return the file itself or the one beside it that has one of these endings.

    Raises:
        UnreadableFileError: There is none.
    """
    found = [path] if path.suffix.lower() in endings else siblings(path, *endings)
    if not found:
        text = Message(
            "{file} needs {name} beside it, which is missing",
            file=path.name,
            name=" / ".join(path.stem + one for one in endings),
        )
        raise UnreadableFileError(text, fault=faults.INPUT)
    return found[0]


def no_files(folder: Path, pattern: str) -> UnreadableFileError:
    """Return the error of a folder without a file of a format."""
    message = Message("{folder} contains no files {pattern}", folder=folder, pattern=pattern)
    return UnreadableFileError(message, fault=faults.INPUT)
