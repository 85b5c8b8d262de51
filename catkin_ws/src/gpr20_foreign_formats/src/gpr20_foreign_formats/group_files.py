"""What the readers of the group's files share: which files are read, and what no VNA measures.

A value that cannot be right is refused by its file; what may be right is a decision in the log.
"""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path
from typing import DefaultDict, Dict, List, Pattern, Tuple

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_common.message import Message
from gpr20_foreign_formats.header import Header
from gpr20_survey.files.file_sums import regular_files

NAMED = 3
LOWEST_STOP_HZ, HIGHEST_HZ = 1e7, 1e12
"""A sweep in GHz, MHz or kHz that is read as Hz ends below the first."""
MOST_POINTS = 100_000
MOST_S21, PASSIVE_S21 = 1e6, 1.0
"""What no instrument measures, and what antennas without an amplifier do not exceed."""
FARTHEST_MM = 10_000.0


def files_of_samples(
    folder: Path, rule: Pattern[str], ending: str, example: str, *beside: str
) -> Tuple[List[Path], List[Message]]:
    """Return the files of samples, in the order of their names, and what others there are.

    Hidden files are none of the user's: those of a desktop, or of the file system of a stick.

    Args:
        folder: Their folder.
        rule: Form of their names.
        ending: What names of samples contain.
        example: A name of that form.
        *beside: Names of files that are no samples, but are read too.

    Raises:
        AnalysisError: There is none.
        UnreadableFileError: There are others that look like samples, but would not be read.
    """
    own = sorted(one for one in folder.iterdir() if rule.fullmatch(one.name))
    if not own:
        raise AnalysisError(
            Message("{folder} contains no files {pattern}", folder=folder, pattern=example),
            fault=faults.NO_INPUT,
        )
    read = {*beside, *(one.name for one in own)}
    others = [
        one for one in regular_files(folder) if one not in read and not re.search(r"(^|/)\.", one)
    ]
    left_out = [one for one in others if ending in one.lower()]
    if left_out:
        raise UnreadableFileError(
            Message(
                "{folder} also holds {count} files that look like samples but would not be read: "
                "{files}. Give them names such as {example} in the folder, or move them away",
                folder=folder.name,
                count=len(left_out),
                files=some(left_out),
                example=example,
            ),
            fault=faults.FILE_CONTENT,
        )
    if not others:
        return own, []
    return own, [
        Message(
            "{count} other files of the folder are no samples and were not read: {files}",
            count=len(others),
            files=some(others),
        )
    ]


def some(names: List[str]) -> str:
    """Return the first few names, with dots for the others."""
    return ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")


def number(header: Header, key: str, lowest: float, highest: float) -> float:
    """Return an entry that is a number, and neither a text nor true or false.

    Raises:
        UnreadableFileError: It is missing, no number, or out of range.
    """
    found = np.asarray(header.entries.get(key))
    if found.dtype.kind not in "iuf" or found.size != 1:
        raise header.refused(
            key,
            Message(
                "a number, no text, between {lowest:g} and {highest:g}",
                lowest=lowest,
                highest=highest,
            ),
        )
    return header.number(key, lowest, highest)


def check_sweep(file: str, start_hz: float, stop_hz: float) -> None:
    """Refuse a sweep in another unit, or in another order.

    Raises:
        UnreadableFileError: It is one.
    """
    ends = {"first frequency [Hz]": start_hz, "last frequency [Hz]": stop_hz}
    first, last = ends
    Header(file, ends).number(last, LOWEST_STOP_HZ, HIGHEST_HZ)
    # The smallest that is above zero.
    Header(file, ends).number(first, float(np.finfo(np.float64).tiny), stop_hz)


class CheckedTraces:
    """Looks at the traces of one import."""

    def __init__(self) -> None:
        self._count = 0
        self._names: Dict[bytes, str] = {}
        self._zero: List[str] = []
        self._same: List[str] = []
        self._large: DefaultDict[float, List[str]] = defaultdict(list)

    def take(self, name: str, values: np.ndarray) -> np.ndarray:
        """Return the complex numbers of a trace; NaN if they are all 0, so nothing was measured.

        Args:
            name: Of its file, or its place.
            values: As they were read.

        Raises:
            UnreadableFileError: No instrument measures such numbers.
        """
        self._count += 1
        largest = float(max(np.abs(values.real).max(), np.abs(values.imag).max()))
        if largest > MOST_S21:
            raise UnreadableFileError(
                Message(
                    "{file} holds {found:g}, which no instrument measures; S21 is linear, at most "
                    "{passive:g} for antennas without an amplifier",
                    file=name,
                    found=largest,
                    passive=PASSIVE_S21,
                ),
                fault=faults.FILE_CONTENT,
            )
        if largest == 0.0:
            self._zero.append(name)
            return np.full_like(values, complex(np.nan, np.nan))
        if largest > PASSIVE_S21:
            self._large[largest].append(name)
        if np.isfinite(largest):
            first = self._names.setdefault(values.tobytes(), name)
            if first != name:
                self._same.append(f"{name} = {first}")
        return values

    def decisions(self) -> List[Message]:
        """Return what is doubtful, for the log.

        Raises:
            UnreadableFileError: All traces are 0.
        """
        found = []
        if self._zero:
            zero = Message(
                "{count} samples hold only 0 and count as missing, for nothing was measured: "
                "{files}",
                count=len(self._zero),
                files=some(self._zero),
            )
            if len(self._zero) == self._count:
                raise UnreadableFileError(zero, fault=faults.FILE_CONTENT)
            found.append(zero)
        if self._same:
            found.append(
                Message(
                    "{count} samples hold exactly the numbers of another, which an instrument does "
                    "not do; they were kept: {files}",
                    count=len(self._same),
                    files=some(self._same),
                )
            )
        if self._large:
            largest = max(self._large)
            found.append(
                Message(
                    "{count} samples exceed {passive:g}, which antennas without an amplifier do "
                    "not, up to {largest:g} in {file}; they were kept. S21 must be linear, not dB",
                    count=sum(map(len, self._large.values())),
                    passive=PASSIVE_S21,
                    largest=largest,
                    file=self._large[largest][0],
                )
            )
        return found
