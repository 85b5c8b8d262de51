"""Export and import of surveys, by the name of the format."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Iterable, Optional, Tuple, Union

import xarray as xr

from gpr20_analysis import dataset, faults
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
from gpr20_analysis.formats.lost_imaginary import with_imaginary_parts
from gpr20_analysis.formats.sums_beside import (
    checked_facts,
    remove_sums,
    sums_path,
    write_sums,
)
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.progress import Progress, no_progress
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason

MERGED = ".h5"
Writer = Callable[[xr.Dataset, Path, Progress], Message]


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        write: Writes a survey to a path and returns what was written.
        ending: Ending of the file's name; empty: a folder with one file per sample.
        holds: Patterns of the file names in the folder.
    """

    write: Writer
    ending: str = ""
    holds: Tuple[str, ...] = ()

    @property
    def has_own_checksum(self) -> bool:
        """Whether its files contain their checksum, so that none is needed beside them."""
        return self.ending in (NETCDF, ZARR, MERGED)


Count = Callable[[xr.Dataset, Path, Progress], int]


def _files(write: Count) -> Writer:
    return lambda survey, path, progress: Message(
        "{count} files", count=write(survey, path, progress)
    )


def _samples(write: Count) -> Writer:
    return lambda survey, path, progress: Message(
        "{count} samples", count=write(survey, path, progress)
    )


def _traces(write: Count) -> Writer:
    return lambda survey, path, progress: Message(
        "{count} traces", count=write(survey, path, progress)
    )


def _write_dataset(survey: xr.Dataset, path: Path, _: Progress) -> Message:
    write_dataset(survey, path)
    return Message("all data")


def _write_merged(survey: xr.Dataset, path: Path, _: Progress) -> Message:
    merged_hdf5.write_merged(survey, path, path.stem)
    if dataset.A_SCAN in survey:
        return Message("A-scans over time")
    return Message("A-scans over frequency")


EXPORTS: Dict[str, Format] = {
    "netcdf": Format(_write_dataset, NETCDF),
    "zarr": Format(_write_dataset, ZARR),
    "group-csv": Format(
        _files(group_csv.write_group_csv), holds=("VNA_*.csv", "TIME_*.csv", group_csv.TIMES_FILE)
    ),
    "merged-hdf5": Format(_write_merged, MERGED),
    "csv": Format(_samples(plain_csv.write_plain_csv), ".csv"),
    "segy": Format(_traces(segy.write_segy), ".sgy"),
    "touchstone": Format(_files(touchstone.write_touchstone), holds=("[0-9]*_X*_Y*_Z*.s2p",)),
    "original-json": Format(_files(original_json.write_original), holds=("X*_Y*_Z*.json",)),
}
IMPORTS = ("group-csv", "merged-hdf5", "gprmax", "original-json")


def export_survey(
    survey: xr.Dataset, path: Union[str, Path], form: str, progress: Progress = no_progress
) -> Dict[Path, Message]:
    """Write a survey; each file or folder is complete or does not exist.

    Args:
        survey: Dataset of a survey.
        path: File, or folder for the formats with one file per sample. It is replaced.
        form: A key of `EXPORTS`.
        progress: Shows the progress.

    Returns:
        The content of each file or folder; SEG-Y has one file per polarization. Checksums are
        in the file, or else in a file NAME.sha256 beside it.

    Raises:
        ExportError: The format cannot hold the survey, the name does not have the format's
            ending, or the output cannot be written.
        MissingLibraryError: A library is not installed.
    """
    path = Path(path).expanduser()
    check_ending(path, form)
    if ADVANCE in survey and form in IMPORTS:
        raise ExportError(
            Message(
                "the step time_zero has shifted the data, which the format {format} cannot record, "
                "so depths would be wrong after an import; export the data without this step",
                format=form,
            ),
            fault=faults.FORMAT,
        )
    written = {}
    for turn, own in enumerate(output_paths(survey, path, form)):
        part = survey.isel({dataset.POLARIZATION: [turn]}) if form == "segy" else survey
        if EXPORTS[form].ending in (NETCDF, ZARR):
            written[own] = EXPORTS[form].write(part, own, progress)  # atomic by itself
            continue
        if not EXPORTS[form].has_own_checksum:
            _remove_sums(own)
        with atomic_output(own, int(part.nbytes)) as place:
            written[own] = EXPORTS[form].write(part, place, progress)
        if not EXPORTS[form].has_own_checksum:
            with atomic_output(sums_path(own)) as place:
                write_sums(own, part, place)
    return written


def _remove_sums(path: Path) -> None:
    try:
        remove_sums(path)
    except OSError as error:
        raise ExportError(
            Message("{path} cannot be replaced: {reason}", path=path, reason=os_reason(error))
        ) from error


def output_paths(survey: xr.Dataset, path: Path, form: str) -> Tuple[Path, ...]:
    """Return the files or folders that are written, without those of checksums beside them."""
    if form != "segy":
        return (path,)
    return tuple(segy.file_of(path, turn) for turn in survey[dataset.POLARIZATION].values)


def check_ending(path: Path, form: str) -> None:
    """Check that a path has the ending of its format.

    Raises:
        ExportError: It has another one, or the format is unknown.
    """
    if form not in EXPORTS:
        raise ExportError(_unknown(form, EXPORTS), fault=faults.OPTION)
    ending = EXPORTS[form].ending
    if ending and path.suffix != ending:
        raise ExportError(
            Message(
                "{file} must end in {ending} for the format {format}",
                file=path.name,
                ending=ending,
                format=form,
            )
        )


def import_survey(
    path: Union[str, Path],
    form: str,
    band: Optional[gprmax.Band] = None,
    height_m: Optional[float] = None,
    source: Optional[str] = None,
    progress: Progress = no_progress,
) -> xr.Dataset:
    """Read measurements and simulations of other programs as the Dataset of a survey.

    Args:
        path: File, or folder of files.
        form: One of `IMPORTS`.
        band: Frequencies for the spectra of a gprMax simulation; None: those of the robot.
        height_m: Antenna height of the simulation [m].
        source: Source signal of the simulation, see `gprmax_source.source_of`.
        progress: Shows the progress.

    Returns:
        The Dataset.

    Raises:
        AnalysisError: It does not have this format, is damaged, or differs from its checksums.
    """
    path = Path(path).expanduser()
    if form == "group-csv":
        return with_imaginary_parts(group_csv.read_group_csv(path, progress, checked_facts(path)))
    if form == "merged-hdf5":
        return with_imaginary_parts(merged_hdf5.read_merged(path))
    if form == "original-json":
        return original_json.read_original(path, progress, checked_facts(path))
    if form == "gprmax":
        return gprmax.read_gprmax(path, band or gprmax.Band(), height_m, source, progress)
    raise AnalysisError(_unknown(form, IMPORTS))


def _unknown(form: str, formats: Iterable[str]) -> Message:
    return Message(
        "unknown format '{format}'; formats are {formats}",
        format=form,
        formats=", ".join(formats),
    )
