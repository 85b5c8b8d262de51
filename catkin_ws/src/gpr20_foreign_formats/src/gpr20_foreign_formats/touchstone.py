"""Folders of Touchstone files: one spectrum per file, as VNAs write them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Dict, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import work
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.work import Progress
from gpr20_common.message import Message
from gpr20_foreign_formats.header import Header, folder_of, no_files, other_kind, refusal
from gpr20_foreign_formats.traces import TAKEN, Traces, as_survey, needs_spacing
from gpr20_survey.files.regular_files import check_regular

FILES = re.compile(r".*\.s[12]p", re.IGNORECASE | re.DOTALL)
ENTRY: Dict[str, Tuple[int, int]] = {".s1p": (0, 0), ".s2p": (1, 0)}
"""What of the scattering matrix is the survey's: S11 of one antenna, S21 of two."""
PLACE = [
    re.compile(rf"(?<![A-Z]){one}([+-]?\d+(?:[.,]\d+)?)(?![.,]?\d)", re.IGNORECASE) for one in "XYZ"
]
BYTES_PER_BYTE = 20.0  # of memory, for a text of numbers
NOISE_COLUMNS = 5
SAME_HZ, LOWEST_HZ, HIGHEST_HZ = 0.5, 1e5, 1e12


def read_touchstone(path: Path, options: ImportOptions, progress: Progress) -> xr.Dataset:
    """Read the files of a folder; places are in their names, such as X50_Y0.5_Z90 (mm, degrees).

    Y and Z may be missing. With a spacing the files are a line in the order of their names, in
    which numbers are ordered as numbers.

    Raises:
        AnalysisError: Places are not known, or frequencies are uneven.
        UnreadableFileError: There is no such file, one is damaged, or frequencies or kinds differ.
    """
    from skrf.io.touchstone import Touchstone  # slow to import

    folder = path if path.is_dir() else path.parent
    paths = [one for one in folder.iterdir() if one.suffix.lower() in ENTRY]
    if not paths:
        raise no_files(folder, ", ".join(f"*{ending}" for ending in ENTRY))
    if len({one.suffix.lower() for one in paths}) != 1:
        raise refusal(
            Message(
                "{folder} must contain files of one kind, .s1p (S11) or .s2p (S21); move the other "
                "kind to another folder",
                folder=folder,
            )
        )
    # Parts that are no numbers and those that are alternate.
    paths.sort(key=lambda one: [
        int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", one.name)
    ])  # fmt: skip
    places = None
    if options.spacing_m is None:
        placed = sorted((_place(folder, one), one) for one in paths)
        paths, places = [one for _, one in placed], np.array([place for place, _ in placed])
    size = sum(one.stat().st_size for one in paths)
    work.require_bytes(BYTES_PER_BYTE * size, Message("reading {file}", file=folder.name))
    read = [_read(Touchstone, one) for one in progress(paths, len(paths))]
    first_hz = read[0][0]
    for one, (own_hz, _) in zip(paths, read):
        if own_hz.shape != first_hz.shape or np.abs(own_hz - first_hz).max() > SAME_HZ:
            raise refusal(
                Message(
                    "{file} has other frequencies than {first}; put it into another folder",
                    file=one.name,
                    first=paths[0].name,
                )
            )
    found = Traces(folder, np.array([one for _, one in read]), frequency_hz=first_hz)
    if places is not None:
        found.x_m, found.y_m, found.rotation_deg = places.T
    survey = as_survey(found, options)
    FrequencyGrid.of(survey)  # refuses uneven frequencies
    return survey


def _read(reader: Any, path: Path) -> Tuple[np.ndarray, np.ndarray]:
    """Return frequencies [Hz] and spectrum."""
    check_regular(path, follow_link=True)
    try:
        file = reader(str(path))
        frequency_hz, matrices = file.get_sparameter_arrays()
        frequency_hz = np.asarray(frequency_hz, np.float64)
        entry = (slice(None), *ENTRY[path.suffix.lower()])
        spectrum = np.asarray(matrices[entry], np.complex128)
        noise = file.noise
        # After a lower frequency scikit-rf takes the parameters of two ports as noise.
        if noise is not None and noise.shape[1] > NOISE_COLUMNS:
            frequency_hz = np.append(frequency_hz, noise[:, 0])
        descends = ~(np.diff(frequency_hz) > 0.0)
        if not len(spectrum) or (spectrum.shape != frequency_hz.shape and not descends.any()):
            raise ValueError("not one value for each frequency")
    # On damaged files scikit-rf and numpy raise exceptions of many kinds.
    except Exception as error:
        raise other_kind(path.name, "Touchstone", error) from error
    if descends.any():
        later = {"frequency [Hz]": frequency_hz[1:][descends][0]}
        higher = Message("higher than the one before; sort the lines by frequency")
        raise Header(path.name, later).refused("frequency [Hz]", higher)
    for one in frequency_hz[[0, -1]]:
        Header(path.name, {"frequency [Hz]": one}).number("frequency [Hz]", LOWEST_HZ, HIGHEST_HZ)
    return frequency_hz, spectrum


def _place(folder: Path, path: Path) -> Tuple[float, float, float]:
    """Return x, y [m] and rotation [deg] by the name of a file."""
    found = [rule.search(path.stem) for rule in PLACE]
    if found[0] is None:
        raise needs_spacing(
            folder, Message("the name {file} has no place such as X50_Y0.5 [mm]", file=path.name)
        )
    x_mm, y_mm, z_deg = (float(one.group(1).replace(",", ".")) if one else 0.0 for one in found)
    return x_mm / MM_PER_M, y_mm / MM_PER_M, z_deg


IMPORT = ImportFormat(read_touchstone, lambda path: folder_of(path, FILES), TAKEN)
