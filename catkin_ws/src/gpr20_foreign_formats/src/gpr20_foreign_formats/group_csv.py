"""The CSV files of the GPR-20 group: one A-scan each, over frequency or over time.

Names hold places, heights and the ends of the axis. The file `time` that a folder over time also
has says the same times without rounding, which changes delays by less than a thousandth.
"""

from __future__ import annotations

import contextlib
import re
from pathlib import Path
from typing import Tuple

import numpy as np
import orjson
import xarray as xr

from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.work import Progress
from gpr20_common.message import Message
from gpr20_foreign_formats.group_files import (
    DEGREES,
    FARTHEST_MM,
    LETTERS_DECIDED,
    MOST_POINTS,
    Samples,
    check_sweep,
    files_of_samples,
    survey_of,
)
from gpr20_foreign_formats.header import Header, folder_of, refusal
from gpr20_survey.files.regular_files import read_regular

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


def read_group_csv(path: Path, _: ImportOptions, progress: Progress) -> xr.Dataset:
    """Read a folder of such files, all over frequency or all over time.

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
