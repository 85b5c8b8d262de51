"""The file names of the GPR-20 group's CSV files, over frequency and over time.

The group's programs find each value by the letters before it, so the word SIMULATED between the
first word and the position does not disturb them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import List

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import ExportError, UnreadableFileError
from gpr20_analysis.formats.provenance import SIMULATED
from gpr20_common.message import Message
from gpr20_foreign_formats.group_files import FARTHEST_MM, MOST_POINTS, check_sweep
from gpr20_foreign_formats.header import Header

VNA, TIME = "VNA", "TIME"
HZ_PER_MHZ, US_PER_S = 1e6, 1e6
MOST = 1e6  # MHz or us
NUMBER = r"(-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)"
CSV = r"\.(?i:csv)"
PLACE = rf"(_{SIMULATED})?_X{NUMBER}_Y{NUMBER}_Or([XY])"
PATTERNS = {
    VNA: re.compile(rf"VNA{PLACE}_Fs{NUMBER}M_Fe{NUMBER}M_Qf(\d+)_H{NUMBER}{CSV}"),
    TIME: re.compile(rf"TIME{PLACE}_Ts{NUMBER}u_Te{NUMBER}u_Qt(\d+)_H{NUMBER}{CSV}"),
}
EXAMPLES = {
    VNA: "VNA_X155_Y310_OrX_Fs600M_Fe6000M_Qf501_H248.csv",
    TIME: "TIME_X155_Y310_OrX_Ts0u_Te0.0463u_Qt501_H248.csv",
}


@dataclass(frozen=True)
class GroupName:
    """The content of a file name.

    Attributes:
        x_mm: Position along X [mm].
        y_mm: Position along Y [mm].
        letter: Polarization, X or Y.
        start: First frequency [MHz] or time [us].
        stop: Last frequency [MHz] or time [us].
        points: Number of frequencies or times.
        height_mm: Height of the antennas [mm].
        simulated: Whether the name says that the data are simulated.
    """

    x_mm: float
    y_mm: float
    letter: str
    start: float
    stop: float
    points: int
    height_mm: float
    simulated: bool


def parsed(name: str, kind: str) -> GroupName:
    """Return the content of a file name.

    Args:
        name: Name of the file.
        kind: `VNA` or `TIME`.

    Raises:
        UnreadableFileError: It has another form.
    """
    found = PATTERNS[kind].fullmatch(name)
    if found is None:
        raise UnreadableFileError(
            Message(
                "the name {file} must have the form {example}", file=name, example=EXAMPLES[kind]
            ),
            fault=faults.INPUT,
        )
    simulated, x_mm, y_mm, letter, start, stop, points, height = found.groups()
    texts = {"X [mm]": x_mm, "Y [mm]": y_mm, "H [mm]": height, "points": points}
    values = Header(name, {**texts, "first": start, "last": stop})
    if kind == VNA:
        check_sweep(name, float(start) * HZ_PER_MHZ, float(stop) * HZ_PER_MHZ)
    return GroupName(
        values.number("X [mm]", -FARTHEST_MM, FARTHEST_MM),
        values.number("Y [mm]", -FARTHEST_MM, FARTHEST_MM),
        letter,
        values.number("first", -MOST, MOST),
        values.number("last", -MOST, MOST),
        values.count("points", 2, MOST_POINTS),
        values.number("H [mm]", 0.0, FARTHEST_MM),
        simulated is not None,
    )


def head_of(kind: str, simulated: bool) -> str:
    """Return what a name begins with."""
    return f"{kind}_{SIMULATED}" if simulated else kind


def axis_part(axis: np.ndarray, kind: str) -> str:
    """Return the part of a name about the frequencies [Hz] or times [s]."""
    first, last = float(axis[0]), float(axis[-1])
    if kind == VNA:
        ends = [f"{plain(one / HZ_PER_MHZ, 6)}M" for one in (first, last)]
        return f"_Fs{ends[0]}_Fe{ends[1]}_Qf{len(axis)}_H"
    ends = [f"{plain(one * US_PER_S, 10)}u" for one in (first, last)]
    return f"_Ts{ends[0]}_Te{ends[1]}_Qt{len(axis)}_H"


def place_texts(values_mm: np.ndarray) -> List[str]:
    """Return coordinates as in file names.

    Raises:
        ExportError: Two of them would be the same.
    """
    # All with decimals or none: the group's tools sort by the numbers in the names.
    whole = bool((np.abs(values_mm - np.round(values_mm)) < 5e-4).all())
    texts = [f"{value:.0f}" if whole else f"{value:.2f}" for value in values_mm]
    if len(set(texts)) < len(texts):
        raise ExportError(
            Message("this format cannot tell positions closer than 0.01 mm apart; use another"),
            fault=faults.INPUT,
        )
    return texts


def plain(value: float, decimals: int) -> str:
    """Return a number without zeros at its end."""
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") or "0"
