"""Export of surveys, by the name of the format."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Dict, List, Tuple, Union

import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import ExportError, check_ending
from gpr20_analysis.formats.dataset_files import NETCDF, write_dataset
from gpr20_analysis.formats.facts import facts_path, write_facts
from gpr20_analysis.formats.plain_csv import write_plain_csv
from gpr20_analysis.formats.segy import file_of, write_segy
from gpr20_analysis.formats.touchstone import write_touchstone
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message

ENDINGS = {"netcdf": NETCDF, "csv": ".csv", "segy": ".sgy", "touchstone": "", "bag": ".bag",
           "ros2": ""}  # fmt: skip
"""The formats, and how their files end; empty: a folder."""
OF_RECORDINGS = ("bag", "ros2")
"""Those that hold the messages of a recording, which a Dataset does not have."""
Writer = Callable[[xr.Dataset, Path, Progress], int]
WRITERS: Dict[str, Tuple[Writer, Message]] = {
    "csv": (write_plain_csv, Message("{count} samples", count=0)),
    "segy": (write_segy, Message("{count} traces", count=0)),
    "touchstone": (write_touchstone, Message("{count} files", count=0)),
}


def export_survey(
    survey: xr.Dataset, path: Union[str, Path], form: str, progress: Progress = no_progress
) -> Dict[Path, Message]:
    """Write a survey; each file or folder is complete or does not exist.

    Args:
        survey: Dataset of a survey.
        path: File, or folder for Touchstone. It is replaced.
        form: netcdf, csv, segy or touchstone.
        progress: Shows the progress.

    Returns:
        The content of each file or folder; SEG-Y has one file per polarization. What a format has
        no place for is in a file NAME.json beside it.

    Raises:
        AnalysisError: The format cannot hold the survey, the name does not have the format's
            ending, or the output cannot be written.
    """
    path = Path(path).expanduser()
    check_format(path, form)
    if form == "netcdf":
        write_dataset(survey, path)
        return {path: Message("all data")}
    if form not in WRITERS:
        raise ExportError(
            Message(
                "the format {format} holds the messages of a recording, which a Dataset does not "
                "have; use `gpr20 export` with the survey's folder or recording",
                format=form,
            ),
            fault=faults.INPUT,
        )
    write, content = WRITERS[form]
    written = {}
    for turn, own in enumerate(output_paths(survey, path, form)):
        part = survey.isel({dataset.POLARIZATION: [turn]}) if form == "segy" else survey
        with atomic_output(own, int(part.nbytes)) as place, atomic_output(facts_path(own)) as facts:
            count = write(part, place, progress)
            write_facts(part, facts)
        written[own] = content.with_values({"count": count})
    return written


def output_paths(survey: xr.Dataset, path: Path, form: str) -> List[Path]:
    """Return the files or folders that are written, without those of facts beside them."""
    if form != "segy":
        return [path]
    return [file_of(path, turn) for turn in survey[dataset.POLARIZATION].values]


def check_format(path: Path, form: str) -> None:
    """Check that a path has the ending of its format.

    Raises:
        AnalysisError: It has another one, or there is no such format.
    """
    if form not in ENDINGS:
        raise ExportError(
            Message(
                "the format '{format}' does not exist; there are: {names}",
                format=form,
                names=", ".join(ENDINGS),
            )
        )
    if ENDINGS[form]:
        check_ending(path, (ENDINGS[form],))
