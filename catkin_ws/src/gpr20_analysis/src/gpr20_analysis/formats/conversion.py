"""Surveys into formats of others and back, by the name of the format."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Optional, Tuple, Union

import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import AnalysisError, ExportError
from gpr20_analysis.formats import (
    gprmax,
    group_csv,
    merged_hdf5,
    original_json,
    plain_csv,
    segy,
    touchstone,
)
from gpr20_analysis.formats.dataset_files import NETCDF, ZARR, write_dataset
from gpr20_analysis.progress import Progress, silent

Writer = Callable[[xr.Dataset, Path, Progress], str]


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        write: Writes a survey to a path and says what.
        ending: What a file's name ends in; empty: a folder of one file per sample.
        holds: Patterns of the names in the folder.
    """

    write: Writer
    ending: str = ""
    holds: Tuple[str, ...] = ()


def _counting(write: Callable[[xr.Dataset, Path, Progress], int], counted: str) -> Writer:
    return lambda survey, path, progress: f"{write(survey, path, progress)} {counted}"


def _write_dataset(survey: xr.Dataset, path: Path, _: Progress) -> str:
    write_dataset(survey, path)
    return "everything"


def _write_merged(survey: xr.Dataset, path: Path, _: Progress) -> str:
    merged_hdf5.write_merged(survey, path, path.stem)
    return f"A-scans over {'time' if dataset.A_SCAN in survey else 'frequency'}"


EXPORTS: Dict[str, Format] = {
    "netcdf": Format(_write_dataset, NETCDF),
    "zarr": Format(_write_dataset, ZARR),
    "group-csv": Format(_counting(group_csv.write_group_csv, "files"), holds=("VNA_X*.csv",)),
    "merged-hdf5": Format(_write_merged, ".h5"),
    "csv": Format(_counting(plain_csv.write_plain_csv, "samples"), ".csv"),
    "segy": Format(_counting(segy.write_segy, "traces"), ".sgy"),
    "touchstone": Format(
        _counting(touchstone.write_touchstone, "files"), holds=("[0-9]*_X*_Y*_Z*.s2p",)
    ),
    "original-json": Format(
        _counting(original_json.write_original, "files"), holds=("X*_Y*_Z*.json",)
    ),
}
IMPORTS = ("group-csv", "merged-hdf5", "gprmax", "original-json")


def export_survey(
    survey: xr.Dataset, path: Union[str, Path], form: str, progress: Progress = silent
) -> Dict[Path, str]:
    """Write a survey; each file or folder is whole or not there.

    Args:
        survey: Dataset of a survey.
        path: File, or folder for the formats of one file per sample. What is there is replaced.
        form: A key of `EXPORTS`.
        progress: Shows how far it has come.

    Returns:
        What each file or folder holds; SEG-Y has one file per polarization.

    Raises:
        ExportError: The format cannot hold the survey, the name has another ending than the
            format's, or the disk refused.
        MissingLibraryError: A library is not installed.
    """
    path = Path(path).expanduser()
    check_ending(path, form)
    written = {}
    for turn, own in enumerate(output_paths(survey, path, form)):
        part = survey.isel({dataset.POLARIZATION: [turn]}) if form == "segy" else survey
        if EXPORTS[form].ending in (NETCDF, ZARR):
            written[own] = EXPORTS[form].write(part, own, progress)  # atomic by itself
        else:
            with atomic_output(own, int(part.nbytes)) as place:
                written[own] = EXPORTS[form].write(part, place, progress)
    return written


def output_paths(survey: xr.Dataset, path: Path, form: str) -> Tuple[Path, ...]:
    """Return the files or folders that are written."""
    if form != "segy":
        return (path,)
    return tuple(segy.file_of(path, turn) for turn in survey[dataset.POLARIZATION].values)


def check_ending(path: Path, form: str) -> None:
    """Check that a path is named as its format is.

    Raises:
        ExportError: It is not.
    """
    if form not in EXPORTS:
        raise ExportError(f"there is no format '{form}'; formats are {', '.join(EXPORTS)}")
    ending = EXPORTS[form].ending
    if ending and path.suffix != ending:
        raise ExportError(f"{path} must end in {ending} for {form}")


def import_survey(
    path: Union[str, Path],
    form: str,
    band: Optional[gprmax.Band] = None,
    height_m: Optional[float] = None,
    source: Optional[str] = None,
    progress: Progress = silent,
) -> xr.Dataset:
    """Read measurements and simulations of others as the Dataset of a survey.

    Args:
        path: File, or folder of files.
        form: One of `IMPORTS`.
        band: Frequencies of the spectra of a simulation by gprMax; None: those of the robot.
        height_m: Its antenna height [m].
        source: The signal of its source, see `gprmax_source.source_of`.
        progress: Shows how far it has come.

    Raises:
        AnalysisError: It is not of this format, or is damaged.
    """
    path = Path(path).expanduser()
    if form == "group-csv":
        return group_csv.read_group_csv(path, progress)
    if form == "merged-hdf5":
        return merged_hdf5.read_merged(path)
    if form == "original-json":
        return original_json.read_original(path, progress)
    if form == "gprmax":
        return gprmax.read_gprmax(path, band or gprmax.Band(), height_m, source, progress)
    raise AnalysisError(f"there is no format '{form}'; formats are {', '.join(IMPORTS)}")
