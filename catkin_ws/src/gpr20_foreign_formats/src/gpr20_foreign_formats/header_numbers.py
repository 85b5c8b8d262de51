"""Numbers of the headers of other programs' files, checked, and the bytes behind them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Mapping, Optional

from gpr20_analysis import faults, lazy
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_common.message import Message
from gpr20_survey.files.regular_file import check_regular, read_regular

BYTES_PER_SAMPLE = 40.0  # in memory: as stored, in double precision, complex, and on the grid
LONGEST_TEXT = 1 << 20
TEXT_SHOWN = 80


@dataclass(frozen=True)
class Numbers:
    """The entries of a header by name.

    Attributes:
        file: Name of the file, for messages.
        values: Numbers, or texts that should be numbers.
    """

    file: str
    values: Mapping[str, Any]

    def refused(self, key: str, allowed: Message) -> UnreadableFileError:
        """Return the error for an entry."""
        text = Message(
            "{file}: {key} is {found}; it must be {allowed}. The file is damaged, or no file of "
            "this format",
            file=self.file,
            key=key,
            found=str(self.values.get(key, "-"))[:TEXT_SHOWN],
            allowed=allowed,
        )
        return UnreadableFileError(text, fault=faults.FILE_CONTENT)

    def number(
        self, key: str, lowest: float, highest: float, default: Optional[float] = None
    ) -> float:
        """Return a number in a range; the default if there is no such entry.

        Raises:
            UnreadableFileError: It is missing, no number, or out of range.
        """
        found = self.values.get(key, default)
        try:
            value = float(found)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            value = float("nan")
        # Written so that NaN is refused too.
        if not lowest <= value <= highest:
            raise self.refused(
                key, Message("between {lowest:g} and {highest:g}", lowest=lowest, highest=highest)
            )
        return value

    def count(self, key: str, lowest: int, highest: int) -> int:
        """Return a whole number in a range.

        Raises:
            UnreadableFileError: It is missing, not whole, or out of range.
        """
        value = self.number(key, lowest, highest)
        if value != int(value):
            raise self.refused(key, Message("a whole number"))
        return int(value)


def text_entries(path: Path, separator: str) -> Dict[str, str]:
    """Return the entries of a text header, one a line, by their names in capitals.

    Raises:
        UnreadableFileError: It is too long for a header.
        OSError: It cannot be read.
    """
    check_regular(path, follow_link=True)
    if path.stat().st_size > LONGEST_TEXT:
        raise UnreadableFileError(
            Message("{file} is longer than any header; it is another file", file=path.name),
            fault=faults.FILE_CONTENT,
        )
    lines = read_regular(path).decode("latin-1").splitlines()
    pairs = (line.partition(separator) for line in lines if separator in line)
    return {" ".join(key.upper().split()): value.strip() for key, _, value in pairs}


def content_of(path: Path, smallest_sample: int) -> bytes:
    """Return the bytes of a file of samples, if what is made of them fits into the memory.

    Raises:
        TooLargeError: It does not fit.
        OSError: It cannot be read.
    """
    check_regular(path, follow_link=True)
    samples = path.stat().st_size / smallest_sample
    lazy.require_bytes(BYTES_PER_SAMPLE * samples, Message("reading {file}", file=path.name))
    return read_regular(path)


def trace_count(path: Path, size: int, trace_bytes: int) -> int:
    """Return how many traces the bytes behind the header hold.

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


def beside(path: Path, *endings: str) -> Optional[Path]:
    """Return the file of the same name with one of these endings, in any case; None without it."""
    wanted = {path.stem.lower() + one for one in endings}
    found = (one for one in path.parent.iterdir() if one.name.lower() in wanted)
    return min(found, default=None)


def require_beside(path: Path, *endings: str) -> Path:
    """Return the file of the same name with one of these endings, in any case.

    Raises:
        AnalysisError: There is none.
    """
    found = beside(path, *endings)
    if found is None:
        raise AnalysisError(
            Message(
                "{file} needs the file {other} beside it, which is missing",
                file=path.name,
                other=" / ".join(path.stem + one for one in endings),
            ),
            fault=faults.NO_INPUT,
        )
    return found
