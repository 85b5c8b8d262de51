"""Surveys in the files of other programs: the numbers of a Dataset, or the messages of a recording.

Messages keep their times, by which they are sorted. What cannot be read is left out and named.
"""

from __future__ import annotations

import inspect
import tempfile
from pathlib import Path
from typing import Any, Dict, Tuple, Union

import xarray as xr
import yaml

from gpr20_analysis import errors
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.dataset import QUALITY, usable
from gpr20_analysis.errors import (
    ExportError,
    MissingLibraryError,
    UnreadableFileError,
    check_ending,
    library_missing,
)
from gpr20_analysis.formats.dataset_files import NETCDF, write_dataset, write_plain_csv
from gpr20_analysis.read.doubts import recording_doubts
from gpr20_analysis.read.recordings import Lost, all_messages, recording_of
from gpr20_analysis.sentences import DOUBTS, kept_doubts, with_sentences
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message
from gpr20_survey.folder.survey_folder import BAG_FILE, MCAP_FILE
from gpr20_survey.recording.bag import make_bag, write_bag

ENDINGS = {"netcdf": NETCDF, "csv": ".csv", "bag": ".bag", "ros2": ""}
"""The formats, and how their files end; empty: a folder."""
OF_RECORDINGS = ("bag", "ros2")
"""Those that hold the messages of a recording, which a Dataset does not have."""
RecordingExport = Tuple[Message, Dict[str, Any]]
"""What was written, and as attributes of a Dataset what is missing, damaged or doubted."""
BAG_OF_ROS2 = 8
"""The version of its metadata whose names of qualities are numbers, which all releases know."""
WHAT = ("topics", "msgtypes")
"""What a conversion could leave out."""


def export_survey(
    survey: xr.Dataset, path: Union[str, Path], form: str, progress: Progress = no_progress
) -> Message:
    """Write a survey; the file is complete or does not exist.

    Args:
        survey: Dataset of a survey.
        path: The file. It is replaced.
        form: netcdf or csv.
        progress: Shows the progress.

    Returns:
        What was written.

    Raises:
        AnalysisError: The format cannot hold the survey, the name does not have the format's
            ending, or the output cannot be written.
    """
    path = Path(path).expanduser()
    check_format(path, form)
    if form in OF_RECORDINGS:
        raise ExportError(
            Message(
                "the format {format} holds the messages of a recording, which a Dataset does not "
                "have; use `gpr20 export` with the survey's folder or recording",
                format=form,
            ),
            fault=errors.INPUT,
        )
    if form == "netcdf":
        write_dataset(survey, path)
        return _of_dataset(survey)
    with atomic_output(path, int(survey.nbytes)) as place:
        return Message("{count} samples", count=write_plain_csv(survey, place, progress))


def _of_dataset(survey: xr.Dataset) -> Message:
    """Return how much of a survey a Dataset holds; samples without data are marked in it."""
    if QUALITY not in survey:
        return Message("all data")
    count, total = int(usable(survey).sum()), survey[QUALITY].size
    if count == total:
        return Message("all data, {count} samples", count=count)
    return Message("{count} of {total} samples; the others have no data", count=count, total=total)


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


def make_survey_bag(survey: Path) -> RecordingExport:
    """Make the bag in the folder of a survey, as the storage does when a survey has ended.

    Raises:
        AnalysisError: It is not the folder of a survey, or has no MCAP.
        ProcessingError: Somebody writes the survey, or the disk refused.
    """
    recording, lost = recording_of(survey / MCAP_FILE), Lost()
    make_bag(survey)
    for _message in all_messages(recording, lost):
        pass  # what of it is damaged is known behind its end
    return _export(recording, lost, Message("all messages of {file}", file=MCAP_FILE))


def export_recording(survey: Path, path: Path, form: str, progress: Progress) -> RecordingExport:
    """Write every whole message of a survey's recording; the bag is complete or does not exist.

    Args:
        survey: Folder of a survey, bag or MCAP file, finished or cut off.
        path: File of a bag of ROS 1, or folder of one of ROS 2; it is replaced.
        form: "bag" or "ros2".
        progress: Shows the progress.

    Raises:
        AnalysisError: It has no recording of ROS 1, no message of it can be read, or the bag
            cannot be written.
        OSError: It cannot be read.
    """
    recording, lost = recording_of(survey), Lost()
    messages = progress(all_messages(recording, lost), None)
    size = 2 * recording.stat().st_size
    with tempfile.TemporaryDirectory() as beside, atomic_output(path, size) as place:
        bag = place if form == "bag" else Path(beside) / BAG_FILE
        count = write_bag(messages, bag)
        if not count:
            raise UnreadableFileError(
                Message("{file} has no message that can be read", file=recording.name),
                fault=errors.FILE_DAMAGED,
            )
        if form == "ros2":
            _convert(bag, place)
            _note(place, recording, lost)
    return _export(recording, lost, Message("{count} messages", count=count))


def _convert(bag: Path, folder: Path) -> None:
    from rosbags.convert import convert  # its import takes 0.1 s
    from rosbags.convert.converter import ConverterError

    options: Dict[str, Any] = {
        **{"dst_storage": "mcap", "dst_version": BAG_OF_ROS2, "compress": None},
        **{"compress_mode": "file", "default_typestore": None, "typestore": None},
        **{f"{word}_{what}": () for word in ("exclude", "include") for what in WHAT},
    }
    if set(options) - inspect.signature(convert).parameters.keys():
        raise MissingLibraryError(library_missing("rosbags 0.10 or later"))
    try:
        convert([bag], folder, **options)
    except ConverterError as error:
        raise UnreadableFileError(
            Message("the recording cannot be converted to ROS 2", details=error),
            fault=errors.INPUT,
        ) from error


def _note(folder: Path, recording: Path, lost: Lost) -> None:
    """Write into the metadata of a bag of ROS 2 what is doubted or lost."""
    path = folder / "metadata.yaml"
    described = yaml.safe_load(path.read_text(encoding="utf-8"))
    losses = [str(one) for one in (*lost.missing, *lost.faults)]
    said = {DOUBTS: kept_doubts(recording_doubts(recording)), "lost": losses}
    custom = {name: "; ".join(texts) for name, texts in said.items() if texts}
    described["rosbag2_bagfile_information"]["custom_data"] = custom
    path.write_text(yaml.safe_dump(described, sort_keys=False), encoding="utf-8")


def _export(recording: Path, lost: Lost, content: Message) -> RecordingExport:
    doubts = recording_doubts(recording)
    return content, with_sentences({}, missing=lost.missing, faults=lost.faults, doubts=doubts)
