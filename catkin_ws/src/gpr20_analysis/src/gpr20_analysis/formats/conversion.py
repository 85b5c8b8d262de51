"""Export and import of surveys, by the name of the format."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Dict, Optional, Tuple, Union

import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.entry_points import ExtensionPoint
from gpr20_analysis.errors import ExportError
from gpr20_analysis.formats import plain_csv, ros1_bag, ros2_bag, segy, touchstone
from gpr20_analysis.formats.dataset_files import NETCDF, ZARR, write_dataset
from gpr20_analysis.formats.format import (
    IMPORTS,
    Band,
    ExportFormat,
    ImportFormat,
    ImportOptions,
    Writer,
    files_of,
)
from gpr20_analysis.formats.recognition import refuse_device
from gpr20_analysis.formats.sums_beside import remove_sums, sums_path, write_sums
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.read.doubts import survey_doubts
from gpr20_analysis.sentences import FAULTS, with_doubts
from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_survey.plan.imported import IMPORTED, TIMES_KNOWN

Count = Callable[[xr.Dataset, Path, Progress], int]


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


EXPORTS = ExtensionPoint(
    "gpr20_analysis.exports",
    Message("the format"),
    fault=faults.STEPS,
    own={
        "netcdf": ExportFormat(_write_dataset, NETCDF, has_own_checksum=True),
        "zarr": ExportFormat(_write_dataset, ZARR, has_own_checksum=True),
        "csv": ExportFormat(_samples(plain_csv.write_plain_csv), ".csv"),
        "segy": ExportFormat(_traces(segy.write_segy), ".sgy"),
        "touchstone": ExportFormat(
            files_of(touchstone.write_touchstone), holds=("[0-9]*_X*_Y*_Z*.s2p",)
        ),
        "bag": ros1_bag.ROS1,
        "ros2": ros2_bag.ROS2,
    },
    kind=ExportFormat,
)
"""By this, other packages add formats that surveys can be written in."""


def export_format(name: str) -> ExportFormat:
    """Return the format of a name.

    Raises:
        MissingLibraryError: Its package is not installed.
        AnalysisError: There is none, or its package cannot be used.
    """
    found: ExportFormat = EXPORTS.find(name)
    return found


def export_survey(
    survey: xr.Dataset, path: Union[str, Path], form: str, progress: Progress = no_progress
) -> Dict[Path, Message]:
    """Write a survey; each file or folder is complete or does not exist.

    Args:
        survey: Dataset of a survey.
        path: File, or folder for the formats with one file per sample. It is replaced.
        form: Name of a format, of this package or of an installed one.
        progress: Shows the progress.

    Returns:
        The content of each file or folder; SEG-Y has one file per polarization. Checksums are
        in the file, or else in a file NAME.sha256 beside it.

    Raises:
        ExportError: The format cannot hold the survey, the name does not have the format's
            ending, or the output cannot be written.
        MissingLibraryError: A library, or the package of the format, is not installed.
    """
    path = Path(path).expanduser()
    check_ending(path, form)
    # Those of this package say so themselves.
    if ADVANCE in survey and form in IMPORTS.names() and form not in EXPORTS.own:
        raise ExportError(
            Message(
                "the step time_zero has shifted the data, which the format {format} cannot record, "
                "so depths would be wrong after an import; export the data without this step",
                format=form,
            ),
            fault=faults.INPUT,
        )
    writer = export_format(form)
    written = {}
    for turn, own in enumerate(output_paths(survey, path, form)):
        part = survey.isel({dataset.POLARIZATION: [turn]}) if form == "segy" else survey
        if writer.ending in (NETCDF, ZARR):
            written[own] = writer.write(part, own, progress)  # atomic by itself
            continue
        if not writer.has_own_checksum:
            _remove_sums(own)
        with atomic_output(own, int(part.nbytes)) as place:
            written[own] = writer.write(part, place, progress)
        if not writer.has_own_checksum:
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
        ExportError: It has another one.
        AnalysisError: The format is unknown, or of a package that cannot be used.
    """
    ending = export_format(form).ending
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
    band: Optional[Band] = None,
    height_m: Optional[float] = None,
    source: Optional[str] = None,
    progress: Progress = no_progress,
    *,
    time_zero_s: Optional[float] = None,
    separation_m: Optional[float] = None,
    spacing_m: Optional[float] = None,
    channel: Optional[int] = None,
    interval_s: Optional[float] = None,
) -> xr.Dataset:
    """Read measurements and simulations of other programs as the Dataset of a survey.

    Args:
        path: File, or folder of files.
        form: Name of a format of an installed package.
        band: Frequencies for the spectra of a simulation; None: those of the robot.
        height_m: Antenna height [m]; None: as recorded, or unknown.
        source: Source signal of the simulation, as after `--source`.
        progress: Shows the progress.
        time_zero_s: Time of the record at which the pulse leaves the antennas, counted from the
            first sample [s]; None: as recorded.
        separation_m: Distance between the antennas [m]; None: as recorded.
        spacing_m: Distance between traces along a line [m]; None: as recorded.
        channel: Number of the channel, from 1; None: the only one.
        interval_s: Time between samples [s]; None: as recorded.

    Raises:
        AnalysisError: It does not have this format, is damaged, or differs from its checksums; or
            the format cannot use an option.
        MissingLibraryError: The package of the format, or a library, is not installed.
    """
    options = ImportOptions(
        band, height_m, source, time_zero_s, separation_m, spacing_m, channel, interval_s
    )
    place = Path(path).expanduser()
    refuse_device(place)
    importer: ImportFormat = IMPORTS.find(form)
    importer.check(form, options)
    found = importer.read(place, options, progress)
    # A Dataset has no times in place of those that are not known.
    entry = {"source": place.name, "format": form, TIMES_KNOWN: True}
    damaged = len(found.attrs.get(FAULTS, ()))
    return with_doubts(found, *survey_doubts({IMPORTED: entry}, (), damaged))
