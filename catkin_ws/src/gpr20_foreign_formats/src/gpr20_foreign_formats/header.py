"""The headers of other instruments' files, with checks, and the files that belong together."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, List, Mapping, Optional, Pattern

import h5py
import numpy as np

from gpr20_analysis import errors, work
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_common.message import Message
from gpr20_survey.files.regular_files import check_regular, read_regular

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
            found=str(self.entries.get(key, "missing"))[:SHOWN],
            allowed=allowed,
        )
        return refusal(text)

    def number(self, key: str, lowest: float, highest: float, default: object = None) -> float:
        """Return a number, also with a decimal comma; the default if there is no such entry.

        Raises:
            UnreadableFileError: It is missing, no number, or out of range.
        """
        found, limits = self.entries.get(key, default), {"lowest": lowest, "highest": highest}
        if self.typed and np.asarray(found).dtype.kind not in "iuf":
            allowed = Message("a number, no text, between {lowest:g} and {highest:g}", **limits)
            raise self.refused(key, allowed)
        if isinstance(found, str) and "." not in found:
            found = found.replace(",", ".")  # of a program under a locale with decimal commas
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


def text_header(path: Path, separator: str, kind: str, key: str) -> Header:
    """Return a text header with an entry in each line, names in capitals; each has this key.

    Raises:
        UnreadableFileError: It is no such header.
        OSError: It cannot be read.
    """
    lines = content_of(path).decode("latin-1").splitlines()
    pairs = (line.partition(separator) for line in lines)
    found = {" ".join(name.upper().split()): value.strip() for name, _, value in pairs}
    if key not in found:
        raise other_kind(path.name, kind)
    return Header(path.name, found)


def refusal(message: Message) -> UnreadableFileError:
    """Return the error of a file that may be whole, but cannot be used as it is."""
    return UnreadableFileError(message, fault=errors.INPUT)


def other_kind(file: str, kind: str, details: object = "") -> UnreadableFileError:
    """Return the error of a file that is of another kind than its reader's."""
    return refusal(
        Message("{file} is not a file of the kind {kind}", file=file, kind=kind, details=details)
    )


@contextlib.contextmanager
def opened_hdf5(path: Path, kind: str, *members: str) -> Iterator[Any]:
    """Open an HDF5 file with these members; whatever fails in the block is its damage.

    Raises:
        UnreadableFileError: It is of another kind, or damaged.
        OSError: It cannot be read.
    """
    check_regular(path, follow_link=True)
    if not h5py.is_hdf5(str(path)):
        raise other_kind(path.name, kind)
    try:
        with h5py.File(str(path), "r") as file:
            if not all(one in file for one in members):
                raise other_kind(path.name, kind)
            yield file
    except AnalysisError:
        raise
    # On damaged files HDF5 and numpy raise exceptions of many kinds.
    except Exception as error:
        text = Message("{file} is damaged", file=path.name, details=error)
        raise UnreadableFileError(text) from error


def hdf5_with(path: Path, *members: str) -> Optional[Path]:
    """Return the path if it is that of an HDF5 file with these members."""
    if path.suffix not in (".h5", ".hdf5", ".out") or not path.is_file():
        return None
    try:
        with h5py.File(str(path), "r") as file:
            return path if all(one in file for one in members) else None
    # On damaged files HDF5 raises exceptions of many kinds; nothing is known of them.
    except Exception:
        return None


def content_of(path: Path) -> bytes:
    """Return the bytes of a file, if its samples fit into the memory.

    Raises:
        TooLargeError: They do not fit.
        OSError: It cannot be read.
    """
    check_regular(path, follow_link=True)
    purpose = Message("reading {file}", file=path.name)
    work.require_bytes(BYTES_PER_SAMPLE * path.stat().st_size, purpose)
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


def stale_count(header: Header, key: str, found: int) -> List[Message]:
    """Return a note if a header says another number of traces than its file holds.

    Instruments write the number before they end a line, and programs that cut one out keep it.
    """
    said = header.number(key, 0.0, np.inf, found)
    note = Message(
        "{file} says {said:g} traces ({key}), but {found} are stored; these are used. If the file "
        "was cut off, the others are lost",
        file=header.file,
        said=said,
        key=key,
        found=found,
    )
    return [] if said == found else [note]


def unread_beside(path: Path, *endings: str) -> List[Message]:
    """Return a note for each file of places or marks beside a file, which is not read."""
    return [
        Message("{file} is not read: positions and marks in it are not used", file=one.name)
        for one in beside(path, *endings)
    ]


def beside(path: Path, *endings: str) -> List[Path]:
    """Return the files of the same name with one of these endings; capitals do not matter."""
    wanted = {path.stem.lower() + one for one in endings}
    return sorted(one for one in path.parent.iterdir() if one.name.lower() in wanted)


def partner(path: Path, *endings: str) -> Path:
    """Return the file itself, or the one beside it that has one of these endings.

    A name in other capitals is taken only if no other file has a better claim to it.

    Raises:
        UnreadableFileError: There is none, or several fit.
    """
    if path.suffix.lower() in endings:
        return path
    fitting = beside(path, *endings)
    own = [one for one in fitting if one.stem == path.stem]
    owned = {one.stem for one in beside(path, path.suffix.lower())}
    found = own or [one for one in fitting if one.stem not in owned]
    if len(found) == 1:
        return found[0]
    raise refusal(
        Message(
            "{file} needs one file {names} beside it; there are: {found}",
            file=path.name,
            names=" / ".join(path.stem + one for one in endings),
            found=", ".join(one.name for one in found) or "-",
        )
    )


def folder_of(path: Path, rule: Pattern[str]) -> Optional[Path]:
    """Return the folder of samples with such names, also of one of them; None if it is none."""
    folder = path if path.is_dir() else path.parent
    names = [one.name for one in path.iterdir()] if path.is_dir() else [path.name]
    return folder if path.exists() and any(map(rule.fullmatch, names)) else None


def no_files(folder: Path, pattern: str) -> UnreadableFileError:
    """Return the error of a folder without a file of a format."""
    return refusal(Message("{folder} contains no files {pattern}", folder=folder, pattern=pattern))
