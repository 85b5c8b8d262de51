"""Folders of Touchstone files: one spectrum per file, as `gpr20 export` and VNAs write them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import faults, lazy
from gpr20_analysis.errors import (
    AnalysisError,
    MissingLibraryError,
    UnreadableFileError,
    library_missing,
)
from gpr20_analysis.formats.format import ImportFormat, ImportOptions
from gpr20_analysis.formats.provenance import SIMULATED
from gpr20_analysis.formats.sums_beside import checked_facts
from gpr20_analysis.formats.touchstone import HEIGHT_WORDS, MOVED
from gpr20_analysis.processing.display import DISPLAY_ONLY
from gpr20_analysis.progress import Progress
from gpr20_analysis.sentences import with_sentence
from gpr20_common.message import Message
from gpr20_foreign_formats.segy import MOVED_NOTE
from gpr20_foreign_formats.traces import TRACES, Traces, as_survey, needs_spacing
from gpr20_survey.files.regular_file import check_regular

ENTRY: Dict[str, Tuple[int, int]] = {".s1p": (0, 0), ".s2p": (1, 0)}
"""What of the scattering matrix is the survey's: S11 of one antenna, S21 of two."""
PLACE = {one: re.compile(rf"(?<![A-Za-z]){one}([+-]?\d+(?:\.\d+)?)") for one in "XYZ"}
HEIGHT = re.compile(rf"{re.escape(HEIGHT_WORDS)} (\d[\d.e+-]*)")
MM_PER_M = 1000.0
BYTES_PER_BYTE = 20.0  # of memory, for a text of numbers
SAME_HZ = 0.5
LOWEST_HZ, HIGHEST_HZ = 1e5, 1e12


def read_touchstone(folder: Path, options: ImportOptions, progress: Progress) -> xr.Dataset:
    """Read the files of a folder; places are in their names, such as X50_Y0.5_Z90 (mm, degrees).

    Y and Z may be missing. If X is, the files are a line in the order of their names, with the
    numbers in them as numbers.

    Raises:
        MissingLibraryError: scikit-rf is not installed.
        AnalysisError: There is no such file, or places are not known.
        UnreadableFileError: A file is damaged, or frequencies differ.
    """
    reader = _reader()
    paths = _paths(folder)
    if not paths:
        raise AnalysisError(
            Message("{folder} contains no files {pattern}", folder=folder,
                    pattern=", ".join(f"*{one}" for one in ENTRY)),
            fault=faults.NO_INPUT,
        )  # fmt: skip
    size = sum(one.stat().st_size for one in paths)
    lazy.require_bytes(BYTES_PER_BYTE * size, Message("reading {file}", file=folder.name))
    found: List[np.ndarray] = []
    heights_m: List[float] = []
    is_simulated = was_moved = False
    first_hz = np.empty(0)
    for path in progress(paths, len(paths)):
        frequency_hz, spectrum, comment = _read(reader, path)
        first_hz = first_hz if found else frequency_hz
        if len(frequency_hz) != len(first_hz) or np.ptp(frequency_hz - first_hz) > SAME_HZ:
            raise UnreadableFileError(
                Message(
                    "{file} has other frequencies than {first}", file=path.name, first=paths[0].name
                ),
                fault=faults.FILE_CONTENT,
            )
        found.append(spectrum)
        height = HEIGHT.search(comment)
        heights_m.append(float(height.group(1)) if height else np.nan)
        is_simulated, was_moved = (
            is_simulated or SIMULATED in comment,
            was_moved or MOVED in comment,
        )
    traces = Traces(
        folder,
        np.array(found),
        frequency_hz=first_hz,
        height_m=np.array(heights_m),
        simulated=True if is_simulated else None,
        facts=checked_facts(folder),
    )
    if options.spacing_m is None:
        _add_places(traces, paths)
    data = as_survey(traces, options)
    if was_moved:
        data = data.assign_attrs(with_sentence(data.attrs, DISPLAY_ONLY, MOVED_NOTE))
    return data


def _reader() -> Any:
    try:
        from skrf.io.touchstone import Touchstone
    except ImportError as error:
        raise MissingLibraryError(library_missing("scikit-rf", "touchstone")) from error
    return Touchstone


def _paths(folder: Path) -> List[Path]:
    found = [one for one in folder.glob("*.*") if one.suffix.lower() in ENTRY]
    return sorted(found, key=lambda one: [
        (int(part), "") if part.isdecimal() else (-1, part)
        for part in re.split(r"(\d+)", one.name)
    ])  # fmt: skip


def _read(reader: Any, path: Path) -> Tuple[np.ndarray, np.ndarray, str]:
    """Return frequencies [Hz], spectrum and comments."""
    check_regular(path, follow_link=True)
    try:
        file = reader(str(path))
        frequency_hz, matrices = file.get_sparameter_arrays()
        frequency_hz = np.asarray(frequency_hz, np.float64)
        spectrum = matrices[(slice(None), *ENTRY[path.suffix.lower()])]
        spectrum = np.asarray(spectrum, np.complex128)
        comments = str(file.get_comments())
        if spectrum.shape != frequency_hz.shape:
            raise ValueError(spectrum.shape)
    # On damaged files scikit-rf and numpy raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message("{file} is damaged, or is no Touchstone file", file=path.name, details=error)
        ) from error
    ends = frequency_hz[[0, -1]] if frequency_hz.size else np.array([np.nan, np.nan])
    ascending = frequency_hz.size >= 2 and bool(np.all(np.diff(frequency_hz) > 0.0))
    if not (ascending and ends[0] >= LOWEST_HZ and ends[1] <= HIGHEST_HZ):
        raise UnreadableFileError(
            Message(
                "{file} has {count} frequencies from {first:g} to {last:g} Hz; it must have 2 or "
                "more that ascend, from {lowest:g} to {highest:g} Hz",
                file=path.name,
                count=frequency_hz.size,
                first=ends[0],
                last=ends[1],
                lowest=LOWEST_HZ,
                highest=HIGHEST_HZ,
            ),
            fault=faults.FILE_CONTENT,
        )
    return frequency_hz, spectrum, comments


def _add_places(traces: Traces, paths: List[Path]) -> None:
    names = [{key: rule.search(path.stem) for key, rule in PLACE.items()} for path in paths]
    without = [path.name for path, name in zip(paths, names) if name["X"] is None]
    if without:
        raise needs_spacing(
            traces.path,
            Message("the name {file} has no place such as X50_Y0.5 [mm]", file=without[0]),
        )
    x_mm, y_mm, z_deg = (
        np.array([float(name[key].group(1)) if name[key] else 0.0 for name in names])
        for key in PLACE
    )
    traces.x_m, traces.y_m, traces.rotation_deg = x_mm / MM_PER_M, y_mm / MM_PER_M, z_deg


def _imported(path: Path, options: ImportOptions, progress: Progress) -> xr.Dataset:
    return read_touchstone(path if path.is_dir() else path.parent, options, progress)


def _whole(path: Path) -> Optional[Path]:
    if path.is_dir():
        return path if any(one.suffix.lower() in ENTRY for one in path.iterdir()) else None
    return path.parent if path.suffix.lower() in ENTRY and path.is_file() else None


IMPORT = ImportFormat(_imported, _whole, TRACES)
