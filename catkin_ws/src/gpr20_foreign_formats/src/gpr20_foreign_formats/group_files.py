"""What the group's formats share: letters of rotations, which files are read, what no VNA measures.

A value that cannot be right is refused by its file; what may be right is a decision in the log.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Dict, List, Pattern, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.errors import ExportError, UnreadableFileError
from gpr20_common.message import Message
from gpr20_foreign_formats.header import Header, no_files
from gpr20_survey.files.file_sums import regular_files

DEGREES: Dict[str, float] = {"X": 0.0, "Y": 90.0}
TOLERANCE_DEG = 1.0  # half a motor step
DECIDED = Message(
    "the letters X and Y are rotations of 0 and 90 deg; the files do not name the direction of the "
    "rotation"
)
"""What the importers of these files decide."""
PHASE_DECIDED = Message(
    "the phase of a later echo falls faster with frequency, as a VNA measures it; no sign was "
    "changed"
)
"""What the importers of spectra decide."""

NAMED = 3
LOWEST_STOP_HZ, HIGHEST_HZ = 1e7, 1e12
"""A sweep in GHz, MHz or kHz that is read as Hz ends below the first."""
MOST_POINTS = 100_000
MOST_S21, PASSIVE_S21 = 1e6, 1.0
"""What no instrument measures, and what antennas without an amplifier do not exceed."""
ALIKE = Message("files that look like samples, but would not be read")
OTHERS = Message("other files of the folder, which were not read")
ZERO = Message("samples of only 0, which count as missing, for nothing was measured")
SAME = Message(
    "samples with exactly the numbers of another, as no instrument gives; they were kept"
)
LARGE = Message(
    "samples with |S21| above 1, so with an amplifier or in dB where linear is read; they were kept"
)
HEIGHT = Message(
    "samples with a height outside of 10 to 1000 mm, perhaps in another unit; they were kept"
)
HEIGHTS_M = (0.01, 1.0)
FARTHEST_MM = 10_000.0


def letters(survey: xr.Dataset) -> Dict[str, int]:
    """Return the index of the polarization of each letter, X or Y.

    Raises:
        ExportError: A rotation has no letter.
    """
    found: Dict[str, int] = {}
    for index, rotation_deg in enumerate(survey[dataset.POLARIZATION].values):
        letter = next(
            (one for one, own in DEGREES.items() if abs(rotation_deg - own) <= TOLERANCE_DEG), None
        )
        if letter is None or letter in found:
            raise ExportError(
                Message(
                    "the rotations of the antennas are {rotations} deg; this format supports only "
                    "0 (X) and 90 (Y); select these with the step polarization",
                    rotations=", ".join(f"{one:g}" for one in survey[dataset.POLARIZATION].values),
                ),
                fault=faults.INPUT,
            )
        found[letter] = index
    return found


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
        raise no_files(folder, example)
    read = {*beside, *(one.name for one in own)}
    others = [
        one for one in regular_files(folder) if one not in read and not re.search(r"(^|/)\.", one)
    ]
    alike = [one for one in others if ending in one.lower()]
    if alike:
        raise UnreadableFileError(
            Message(
                "{folder}: {files}. Give them names such as {example} in this folder, or move them "
                "away",
                folder=folder.name,
                files=listed(ALIKE, alike),
                example=example,
            ),
            fault=faults.INPUT,
        )
    return own, [listed(OTHERS, others)] if others else []


def listed(what: Message, names: List[str]) -> Message:
    """Return what files or samples are, with the first few of them."""
    files = ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")
    return Message("{what}: {count}, {files}", what=what, count=len(names), files=files)


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
        self._names: Dict[bytes, str] = {}
        self._good = False
        self._zero: List[str] = []
        self._same: List[str] = []
        self._large: List[str] = []
        self._height: List[str] = []

    def take(self, name: str, values: np.ndarray, height_m: float = math.nan) -> np.ndarray:
        """Return the complex numbers of a trace; NaN if they are all 0, so nothing was measured.

        Args:
            name: Of its file, or its place.
            values: As they were read.
            height_m: Height of the antennas [m]; NaN: not known.

        Raises:
            UnreadableFileError: No instrument measures such numbers.
        """
        if not (math.isnan(height_m) or HEIGHTS_M[0] <= height_m <= HEIGHTS_M[1]):
            self._height.append(f"{name} ({height_m * 1e3:g} mm)")
        largest = float(max(np.abs(values.real).max(), np.abs(values.imag).max()))
        if largest > MOST_S21:
            key = "|S21|"
            allowed = Message("linear, at most 1 for antennas without an amplifier")
            raise Header(name, {key: f"{largest:g}"}).refused(key, allowed)
        if largest == 0.0:
            self._zero.append(name)
            return np.full_like(values, complex(np.nan, np.nan))
        self._good = True
        if largest > PASSIVE_S21:
            self._large.append(f"{name} ({largest:g})")
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
        if self._zero and not self._good:
            raise UnreadableFileError(listed(ZERO, self._zero), fault=faults.INPUT)
        kinds = (
            (ZERO, self._zero),
            (SAME, self._same),
            (LARGE, self._large),
            (HEIGHT, self._height),
        )
        return [listed(what, names) for what, names in kinds if names]
