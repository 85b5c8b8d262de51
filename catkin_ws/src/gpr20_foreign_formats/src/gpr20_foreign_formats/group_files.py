"""What the group's formats share: which files are read, and a survey from their samples.

A value that cannot be right is refused by its file; what may be right is a decision in the log.
"""

from __future__ import annotations

import contextlib
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Dict, List, Optional, Pattern, Sequence, Tuple

import numpy as np
import orjson
import xarray as xr

from gpr20_analysis.dataset import DISPLAY_ONLY, MM_PER_M
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.common import on_grid
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.sentences import with_decisions, with_notes, with_sentence
from gpr20_analysis.work import Progress
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_foreign_formats.header import Header, folder_of, no_files, refusal
from gpr20_survey.files.regular_files import read_regular, regular_files

DEGREES: Dict[str, float] = {"X": 0.0, "Y": 90.0}
LETTERS_DECIDED = Message(
    "the letters X and Y are rotations of 0 and 90 deg; the files do not name the direction of the "
    "rotation"
)
PHASE_DECIDED = Message(
    "the phase of a later echo falls faster with frequency, as a VNA measures it; no sign was "
    "changed"
)
NAMED = 3
LOWEST_STOP_HZ, HIGHEST_HZ = 1e7, 1e12
"""A sweep in GHz, MHz or kHz that is read as Hz ends below the first."""
MOST_POINTS, FARTHEST_MM = 100_000, 10_000.0
MOST_S21, PASSIVE_S21 = 1e6, 1.0
"""What no instrument measures, and what antennas without an amplifier do not exceed."""
ALIKE = Message("files that look like samples, but would not be read")
OTHERS = Message("other files of the folder, which were not read")
ZERO = Message("samples of only 0, which count as missing, for nothing was measured")
LARGE = Message(
    "samples with |S21| above 1, so with an amplifier or in dB where linear is read; they were kept"
)
COPIED = Message(
    "samples whose imaginary part is a copy of the real part, as an old version of the storage "
    "wrote it, so they cannot be imaged"
)
VNA, TIME = "VNA", "TIME"
HEADERS = {VNA: "S21_real,S21_imag", TIME: "A-Scan_real,A-Scan_imag"}
NAMES = re.compile(r"(VNA|TIME)_.*\.csv", re.IGNORECASE | re.DOTALL)
NUMBER = r"(-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)"
PLACE, ENDING = rf"_X{NUMBER}_Y{NUMBER}_Or([XY])", rf"_H{NUMBER}\.(?i:csv)"
PATTERNS = {
    VNA: re.compile(rf"VNA{PLACE}_Fs{NUMBER}M_Fe{NUMBER}M_Qf(\d+){ENDING}"),
    TIME: re.compile(rf"TIME{PLACE}_Ts{NUMBER}u_Te{NUMBER}u_Qt(\d+){ENDING}"),
}
EXAMPLES = {
    VNA: "VNA_X155_Y310_OrX_Fs600M_Fe6000M_Qf501_H248.csv",
    TIME: "TIME_X155_Y310_OrX_Ts0u_Te0.0463u_Qt501_H248.csv",
}
UNITS = Message(
    "in the file names X, Y and H are mm, frequencies MHz and times us, in even steps from the "
    "first to the last"
)
NUMERALS = b"+-.0123456789Ee \t\r"
UNIT = {VNA: 1e6, TIME: 1e-6}  # of the ends in names [Hz or s]
MOST = 1e6  # MHz or us
ROUNDED_S = 5e-11  # by the group's program, of times in names


@dataclass
class Samples:
    """What files of the group hold, over frequency or over time.

    Attributes:
        names: Of the files of the samples, or of their places.
        positions: Rotation [deg], y and x [mm] (sample, 3).
        scans: Complex numbers (sample, point); those of only 0 become NaN.
        heights_m: NaN where not known.
        times: When the samples were measured; None: not known.
        decisions: What was decided where the files say nothing.
    """

    names: Sequence[str]
    positions: np.ndarray
    scans: np.ndarray
    heights_m: np.ndarray
    frequency_hz: Optional[np.ndarray] = None
    delay_s: Optional[np.ndarray] = None
    times: Optional[List[np.datetime64]] = None
    notes: List[Message] = field(default_factory=list)
    decisions: List[Message] = field(default_factory=list)


def survey_of(path: Path, found: Samples) -> xr.Dataset:
    """Return the Dataset of samples, with what is doubtful of them in the log.

    Raises:
        UnreadableFileError: No instrument measures such numbers, all are 0, or two have one place.
    """
    doubtful = _doubtful(found)
    if found.frequency_hz is not None:
        found.decisions.append(PHASE_DECIDED)
    data = on_grid(
        printable(path.name),
        found.positions,
        found.scans,
        found.heights_m.tolist(),
        found.frequency_hz,
        found.notes,
        delay_s=found.delay_s,
        times=found.times,
    )
    data = with_decisions(data, *doubtful, *found.decisions)
    copied = (found.scans.real == found.scans.imag).all(axis=1)
    if not copied.any():
        return data
    reason = _listed(COPIED, [found.names[one] for one in np.flatnonzero(copied)])
    data = data.assign_attrs(with_notes(data, [Message("WARNING: {sentence}", sentence=reason)]))
    return data.assign_attrs(with_sentence(data.attrs, DISPLAY_ONLY, reason))


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
        UnreadableFileError: There is none, or others look like samples, but would not be read.
    """
    names = os.listdir(str(folder)) if folder.is_dir() else ()
    own = sorted(filter(rule.fullmatch, names))
    if not own:
        raise no_files(folder, example)
    read = {*beside, *own}
    others = [
        one for one in regular_files(folder) if one not in read and not re.search(r"(^|/)\.", one)
    ]
    alike = [one for one in others if ending in one.lower()]
    if alike:
        raise refusal(
            Message(
                "{folder}: {files}. Give them names such as {example} in this folder, or move them "
                "away",
                folder=folder.name,
                files=_listed(ALIKE, alike),
                example=example,
            )
        )
    return [folder / one for one in own], [_listed(OTHERS, others)] if others else []


def check_sweep(file: str, start_hz: float, stop_hz: float) -> None:
    """Refuse a sweep in another unit, or in another order.

    Raises:
        UnreadableFileError: It is one.
    """
    ends = Header(file, {"first frequency [Hz]": start_hz, "last frequency [Hz]": stop_hz})
    ends.number("last frequency [Hz]", LOWEST_STOP_HZ, HIGHEST_HZ)
    # The smallest that is above zero.
    ends.number("first frequency [Hz]", float(np.finfo(np.float64).tiny), stop_hz)


def _listed(what: Message, names: Sequence[str]) -> Message:
    """Return what files or samples are, with the first few of them."""
    files = ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")
    return Message("{what}: {count}, {files}", what=what, count=len(names), files=files)


def _doubtful(found: Samples) -> List[Message]:
    names, scans = found.names, found.scans
    largest = np.maximum(np.abs(scans.real), np.abs(scans.imag)).max(axis=1)
    for one in np.flatnonzero(largest > MOST_S21)[:1]:
        allowed = Message("linear, at most 1 for antennas without an amplifier")
        raise Header(names[one], {"|S21|": f"{largest[one]:g}"}).refused("|S21|", allowed)
    zero = largest == 0.0
    if zero.all():
        raise refusal(_listed(ZERO, names))
    scans[zero] = complex(np.nan, np.nan)
    loud = np.flatnonzero(largest > PASSIVE_S21)
    kinds = (
        (ZERO, [names[one] for one in np.flatnonzero(zero)]),
        (LARGE, [f"{names[one]} ({largest[one]:g})" for one in loud]),
    )
    return [_listed(what, some) for what, some in kinds if some]


def read_group_csv(path: Path, _: ImportOptions, progress: Progress) -> xr.Dataset:
    """Read a folder of CSV files, one A-scan each, all over frequency or all over time.

    Names hold places, heights and the ends of the axis. The file `time` that a folder over time
    also has says the same times without rounding, which changes delays by less than a thousandth.

    Raises:
        UnreadableFileError: There is none, one is damaged, two have the same position, or their
            frequencies differ.
    """
    paths, decisions = files_of_samples(path, NAMES, ".csv", EXAMPLES[VNA], "time")
    kinds = {kind for one in paths for kind in HEADERS if one.name.upper().startswith(kind)}
    named = [_named(one.name, kind) for kind in kinds for one in paths] if len(kinds) == 1 else []
    axes = sorted({axis for _, axis in named})
    if len(axes) != 1:
        raise refusal(
            Message(
                "{folder} mixes files over frequency (VNA_) and over time (TIME_), or of different "
                "ends or points: {axes}; put the files of each into a separate folder",
                folder=path,
                axes=", ".join(map(str, axes)) or " / ".join(sorted(kinds)),
            )
        )
    (kind,), ((start, stop, points),) = kinds, axes
    axis = np.linspace(start, stop, points)
    places = np.array([place for place, _ in named])
    found = Samples(
        [one.name for one in paths],
        places[:, :3],
        np.array([_read(one, points, HEADERS[kind]) for one in progress(paths, len(paths))]),
        places[:, 3] / MM_PER_M,
        notes=[Message("heights and positions are rounded as in the file names")],
        decisions=[*decisions, UNITS, LETTERS_DECIDED],
    )
    if kind == VNA:
        found.frequency_hz = axis
    else:
        found.delay_s = axis
        rounded = Message(
            "the times are those of the file names; if these are rounded to 0.1 ns, delays are "
            "wrong by up to {percent:.2g} %",
            percent=100.0 * ROUNDED_S / max(stop - start, ROUNDED_S),
        )
        found.notes.append(rounded)
    return survey_of(path, found)


def _named(name: str, kind: str) -> Tuple[Tuple[float, ...], Tuple[float, float, int]]:
    """Return rotation [deg], y, x and height [mm] by the name of a file; and ends and points."""
    parts = PATTERNS[kind].fullmatch(name)
    if parts is None:
        raise refusal(
            Message(
                "the name {file} must have the form {example}", file=name, example=EXAMPLES[kind]
            )
        )
    keys = ("X [mm]", "Y [mm]", "letter", "first", "last", "points", "H [mm]")
    header = Header(name, dict(zip(keys, parts.groups())))
    y_mm, x_mm = (header.number(key, -FARTHEST_MM, FARTHEST_MM) for key in ("Y [mm]", "X [mm]"))
    start, stop = (header.number(key, -MOST, MOST) * UNIT[kind] for key in ("first", "last"))
    if kind == VNA:
        check_sweep(name, start, stop)
    place = (DEGREES[parts[3]], y_mm, x_mm, header.number("H [mm]", 0.0, FARTHEST_MM))
    return place, (start, stop, header.count("points", 2, MOST_POINTS))


def _read(path: Path, points: int, expected: str) -> np.ndarray:
    first, _, content = read_regular(path).partition(b"\n")
    header = first.decode("utf-8-sig", "replace").strip()
    if header != expected:
        allowed = Message("{header}", header=expected)
        raise Header(path.name, {"first line": header}).refused("first line", allowed)
    if not content.endswith(b"\n"):
        raise UnreadableFileError(
            Message(
                "{file} does not end with a line break, so its last number may be cut off",
                file=path.name,
            )
        )
    content, found = content.rstrip(), np.empty(0)
    if content.translate(None, NUMERALS) == b"\n".join([b","] * points):
        try:  # three times as fast as np.loadtxt
            found = np.array(orjson.loads(b"[%b]" % content.replace(b"\n", b",")), np.float64)
        except orjson.JSONDecodeError:  # numbers such as +1 and .5
            with contextlib.suppress(ValueError):
                found = np.loadtxt(content.decode("ascii").splitlines(), delimiter=",").ravel()
    if len(found) != 2 * points or not np.isfinite(found).all():
        raise UnreadableFileError(
            Message(
                "{file} must hold {points} lines by its name, each of two numbers such as -0.5,"
                "1e-3 and not NaN",
                file=path.name,
                points=points,
            )
        )
    return found.view(np.complex128)


IMPORT = ImportFormat(read_group_csv, lambda path: folder_of(path, NAMES), ("band",))
