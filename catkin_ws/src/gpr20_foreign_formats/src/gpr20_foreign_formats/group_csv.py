"""The CSV files of the GPR-20 group: one A-scan each, over frequency or over time.

A folder over time also has a file `time` with the times, which the names round.
"""

from __future__ import annotations

import contextlib
import re
from pathlib import Path
from typing import List, Optional

import numpy as np
import orjson
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.errors import ExportError, UnreadableFileError
from gpr20_analysis.formats.common import even_step, on_grid
from gpr20_analysis.formats.format import ExportFormat, ImportFormat, ImportOptions, files_of
from gpr20_analysis.formats.provenance import Facts, is_simulated
from gpr20_analysis.formats.sums_beside import checked_facts
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.sentences import with_decisions
from gpr20_common.message import Message
from gpr20_foreign_formats.group_files import (
    DECIDED,
    DEGREES,
    PHASE_DECIDED,
    CheckedTraces,
    files_of_samples,
    letters,
)
from gpr20_foreign_formats.group_names import (
    EXAMPLES,
    HZ_PER_MHZ,
    TIME,
    US_PER_S,
    VNA,
    axis_part,
    head_of,
    parsed,
    place_texts,
    plain,
)
from gpr20_foreign_formats.header import Header
from gpr20_foreign_formats.lost_imaginary import with_imaginary_parts
from gpr20_survey.files.regular_file import open_regular, read_regular

HEADERS = {VNA: "S21_real,S21_imag", TIME: "A-Scan_real,A-Scan_imag"}
NAMES = re.compile(r"(VNA|TIME)_.*\.csv", re.IGNORECASE | re.DOTALL)
UNITS = {
    VNA: Message(
        "in the file names X, Y and H are mm and frequencies are MHz, in even steps from the first "
        "to the last"
    ),
    TIME: Message("in the file names X, Y and H are mm and times are us"),
}
KINDS = {dataset.S21: VNA, dataset.A_SCAN: TIME}
TIMES_FILE, TIMES_HEADER = "time", "Time"
MM_PER_M = 1000.0
NUMBER = b"0123456789+-.eE"
ROUNDED_US = 5e-5
"""Rounding of times in names by the group's program [us]."""


def write_group_csv(survey: xr.Dataset, folder: Path, progress: Progress = no_progress) -> int:
    """Write one file per sample with data and return the number of files.

    Raises:
        ExportError: The format cannot hold the rotations, frequencies or heights.
        OSError: A file exists or cannot be written.
    """
    variable = dataset.A_SCAN if dataset.A_SCAN in survey else dataset.S21
    kind = KINDS[variable]
    last = dataset.DELAY if kind == TIME else dataset.FREQUENCY
    scans = dataset.require(survey, variable, (*dataset.SAMPLE_DIMS, last))
    turns = letters(survey)
    axis = survey[last].values
    if kind == TIME:
        even_step(axis, Message("delay"), "s")
    else:
        even_step(axis, Message("frequency"), "Hz")
    usable = dataset.usable(survey).transpose(*dataset.SAMPLE_DIMS).values
    height_mm = survey[dataset.HEIGHT].transpose(*dataset.SAMPLE_DIMS).values * MM_PER_M
    if not np.isfinite(height_mm[usable]).all():
        raise ExportError(
            Message(
                "{count} samples have no antenna height, which the file names of this format need; "
                "apply the step fill, or choose another format",
                count=np.count_nonzero(~np.isfinite(height_mm[usable])),
            ),
            fault=faults.INPUT,
        )
    head, tail = head_of(kind, is_simulated(survey)), axis_part(axis, kind)
    x_text, y_text = (place_texts(survey[one].values * MM_PER_M) for one in (dataset.X, dataset.Y))
    folder.mkdir(parents=True, exist_ok=True)
    places = [
        (letter, int(row), int(column), turn)
        for letter, turn in turns.items()
        for row, column in np.argwhere(usable[turn])
    ]
    if kind == TIME:
        times = "".join(f"{one!r}\n" for one in axis.tolist())
        (folder / TIMES_FILE).write_text(f"{TIMES_HEADER}\n{times}", encoding="ascii")
    for letter, row, column, turn in progress(places, len(places)):
        height = plain(height_mm[turn, row, column], 2)
        name = f"{head}_X{x_text[column]}_Y{y_text[row]}_Or{letter}{tail}{height}.csv"
        values = np.asarray(scans[turn, row, column])
        lines = [f"{one.real!r},{one.imag!r}" for one in values.tolist()]
        with (folder / name).open("x", encoding="ascii") as stream:
            stream.write("\n".join([HEADERS[kind], *lines, ""]))
    return len(places)


def holds_group_csv(folder: Path) -> bool:
    """Return whether a folder has files with the group's first words."""
    return any(NAMES.fullmatch(one.name) for one in folder.iterdir())


def read_group_csv(
    folder: Path, progress: Progress = no_progress, facts: Optional[Facts] = None
) -> xr.Dataset:
    """Read a folder of such files, all over frequency or all over time.

    Args:
        folder: The folder.
        progress: Shows the progress.
        facts: What is known of the survey besides.

    Raises:
        AnalysisError: There is none.
        UnreadableFileError: A file is damaged, two have the same position, or frequencies differ.
    """
    paths, decisions = files_of_samples(folder, NAMES, ".csv", EXAMPLES[VNA], TIMES_FILE)
    found = {kind: [one for one in paths if one.name.upper().startswith(kind)] for kind in HEADERS}
    if all(found.values()):
        raise UnreadableFileError(
            Message(
                "{folder} has files over frequency (VNA_) and over time (TIME_); put each kind "
                "into a separate folder",
                folder=folder,
            ),
            fault=faults.INPUT,
        )
    kind = next(one for one, paths in found.items() if paths)
    names = {path: parsed(path.name, kind) for path in found[kind]}
    sweeps = {(one.start, one.stop, one.points) for one in names.values()}
    if len(sweeps) > 1:
        raise UnreadableFileError(
            Message(
                "{folder} mixes {kind} (first, last, points): {sweeps}; put the files of each "
                "into a separate folder",
                folder=folder,
                kind=Message("frequencies") if kind == VNA else Message("times"),
                sweeps=sorted(sweeps),
            ),
            fault=faults.INPUT,
        )
    start, stop, points = sweeps.pop()
    notes = [Message("heights and positions are rounded as in the file names")]
    traces = CheckedTraces()
    read = (
        traces.take(path.name, _read(path, points, HEADERS[kind]), names[path].height_mm / MM_PER_M)
        for path in progress(list(names), len(names))
    )
    frequency_hz = delay_s = None
    if kind == VNA:
        frequency_hz = np.linspace(start * HZ_PER_MHZ, stop * HZ_PER_MHZ, points)
    else:
        delay_s = _times(folder, start, stop, points, notes)
    data = on_grid(
        folder.name,
        np.array([(DEGREES[one.letter], one.y_mm, one.x_mm) for one in names.values()]),
        read,
        [one.height_mm / MM_PER_M for one in names.values()],
        frequency_hz,
        notes,
        simulated=True if any(one.simulated for one in names.values()) else None,
        facts=facts,
        delay_s=delay_s,
    )
    return with_decisions(data, *decisions, *traces.decisions())


def _times(
    folder: Path, start_us: float, stop_us: float, points: int, notes: List[Message]
) -> np.ndarray:
    """Return the times of the file `time`, or of the names without it [s]."""
    path = folder / TIMES_FILE
    named_s = np.linspace(start_us / US_PER_S, stop_us / US_PER_S, points)
    if not path.exists():
        notes.append(
            Message(
                "there is no file '{file}', so the times are those of the file names; if these are "
                "rounded to 0.1 ns, delays are wrong by up to {percent:.2g} %",
                file=TIMES_FILE,
                percent=100.0 * ROUNDED_US / max(stop_us - start_us, ROUNDED_US),
            )
        )
        return named_s
    try:
        header, *lines = read_regular(path).decode("ascii").split()
        times_s = np.array(lines, dtype=np.float64)
    except ValueError as error:
        raise UnreadableFileError(Message("{file} is damaged", file=TIMES_FILE)) from error
    # The group's program names the first time 0, whatever it is.
    off_s = np.abs(times_s[-1:] - named_s[-1:])
    step_s = named_s[1] - named_s[0] if points > 1 else 0.0
    even = len(times_s) == points > 1 and np.ptp(np.diff(times_s)) < 1e-3 * step_s
    if header != TIMES_HEADER or not even or off_s[0] > 2.0 * ROUNDED_US / US_PER_S:
        values = {"points": points, "start": start_us, "stop": stop_us}
        allowed = Message("Time and {points} even times, {start:g} to {stop:g} us", **values)
        found = Header(TIMES_FILE, {"content": f"{header} and {len(times_s)}"})
        raise found.refused("content", allowed)
    return times_s


def _read(path: Path, points: int, expected: str) -> np.ndarray:
    with open(open_regular(path, follow_link=True), "rb") as stream:
        header = stream.readline().decode("utf-8-sig", "replace").strip()
        if header != expected:
            allowed = Message("{header}", header=expected)
            raise Header(path.name, {"first line": header}).refused("first line", allowed)
        content = stream.read()
        if not content.endswith(b"\n"):
            raise UnreadableFileError(
                Message(
                    "{file} does not end with a line break, so its last number may be cut off",
                    file=path.name,
                )
            )
    found = _numbers(path, content)
    if found.shape != (points, 2):
        raise UnreadableFileError(
            Message(
                "{file} has {lines} lines of {columns} numbers; by its name it must have {points} "
                "lines of 2",
                file=path.name,
                lines=found.shape[0],
                columns=found.shape[1],
                points=points,
            )
        )
    if not np.isfinite(found).all():
        raise UnreadableFileError(Message("{file} contains NaN or infinite values", file=path.name))
    return found[:, 0] + 1j * found[:, 1]


def _numbers(path: Path, content: bytes) -> np.ndarray:
    """Return the lines of numbers of a file (line, column)."""
    lines = [line for line in content.splitlines() if line.strip()]
    try:
        # JSON is exact too and many times as fast, but knows no `1.` and no `nan`.
        if not content.translate(None, NUMBER).strip(b",\r\n"):
            with contextlib.suppress(orjson.JSONDecodeError):
                return np.array(orjson.loads(b"[[%b]]" % b"],[".join(lines)), np.float64)
        if b"_" in content:
            raise ValueError("no separator of digits is allowed")
        return np.array([line.split(b",") for line in lines]).astype(np.float64)
    except ValueError as error:
        raise UnreadableFileError(
            Message("{file} holds lines that are not two numbers", file=path.name)
        ) from error


def _imported(path: Path, _: ImportOptions, progress: Progress) -> xr.Dataset:
    data = with_imaginary_parts(read_group_csv(path, progress, checked_facts(path)))
    kind = VNA if dataset.S21 in data else TIME
    return with_decisions(data, UNITS[kind], DECIDED, *([PHASE_DECIDED] if kind == VNA else []))


def _whole(path: Path) -> Optional[Path]:
    if path.is_dir():
        return path if holds_group_csv(path) else None
    # One file is no survey; its folder is.
    return path.parent if NAMES.fullmatch(path.name) and path.is_file() else None


IMPORT = ImportFormat(_imported, _whole, ("band",))
EXPORT = ExportFormat(
    files_of(write_group_csv), holds=("VNA_*.csv", "TIME_*.csv", TIMES_FILE), over_time=True
)
