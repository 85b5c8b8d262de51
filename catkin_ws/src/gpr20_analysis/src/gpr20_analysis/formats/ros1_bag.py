"""The bag of ROS 1 of a survey: made beside its recording, or written to another place."""

from __future__ import annotations

from pathlib import Path

from gpr20_analysis import faults
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.format import ExportFormat, RecordingExport, only_recordings
from gpr20_analysis.progress import Progress
from gpr20_analysis.read.doubts import recording_doubts
from gpr20_analysis.read.recordings import BAG, CUT_OFF, MCAP, is_foreign, recording_of
from gpr20_analysis.sentences import with_sentences
from gpr20_common.message import Message
from gpr20_survey.folder import survey_folder
from gpr20_survey.recording.bag import make_bag, write_bag
from gpr20_survey.recording.mcap_reader import StoredMcap


def export_bag(survey: Path, path: Path, progress: Progress) -> RecordingExport:
    """Write every whole message of a survey's MCAP as a bag; it is complete or does not exist.

    Args:
        survey: Folder of a survey, or its MCAP file, finished or cut off.
        path: File to write; it is replaced.
        progress: Shows the progress.

    Raises:
        AnalysisError: There is no MCAP, or the bag cannot be written.
        OSError: The MCAP cannot be read.
    """
    mcap = _mcap_of(survey)
    with atomic_output(path, mcap.path.stat().st_size) as place:
        count = write_bag(progress(mcap.messages(), None), place)
    return _export(mcap, Message("{count} messages", count=count))


def make_survey_bag(survey: Path) -> RecordingExport:
    """Make the bag in the folder of a survey, as the storage does when a survey has ended.

    Raises:
        AnalysisError: It is not the folder of a survey, or has no MCAP.
        ProcessingError: Somebody writes the survey, or the disk refused.
    """
    mcap = _mcap_of(survey / survey_folder.MCAP_FILE)
    make_bag(survey)
    return _export(mcap, Message("all messages of {file}", file=mcap.path.name))


def _mcap_of(survey: Path) -> StoredMcap:
    path = recording_of(survey)
    if path.suffix != MCAP or is_foreign(path):
        raise AnalysisError(
            Message("{path} is no MCAP file of a survey, from which a bag is made", path=path),
            fault=faults.INPUT,
        )
    return StoredMcap(path.resolve())


def _export(mcap: StoredMcap, content: Message) -> RecordingExport:
    said = with_sentences(
        {},
        missing=[] if mcap.is_finished() else [CUT_OFF],
        faults=mcap.faults,
        doubts=recording_doubts(mcap.path),
    )
    return content, said


ROS1 = ExportFormat(
    only_recordings("bag"),
    BAG,
    has_own_checksum=True,
    of_recording=export_bag,
    in_survey=make_survey_bag,
)
