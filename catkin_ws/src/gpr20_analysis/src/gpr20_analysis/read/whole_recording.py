"""Every message of a bag or an MCAP file, whatever its topic, and what could not be read of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterator, List, Optional

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Header
from mcap.well_known import Profile

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError, not_there
from gpr20_analysis.read.recording_files import (
    bag_reader,
    failing_as_unreadable,
    is_bag,
    is_finished,
    is_recording,
    opened,
)
from gpr20_analysis.read.recordings import CUT_OFF, mcap_messages
from gpr20_analysis.read.unindexed_bag import complete_messages
from gpr20_common.message import Message
from gpr20_survey.folder import survey_folder
from gpr20_survey.recording.mcap_reader import TORN, StoredMcap
from gpr20_survey.recording.mcap_writer import LIBRARY
from gpr20_survey.recording.recording import RecordedMessage


@dataclass
class Lost:
    """What could not be read of a recording.

    Attributes:
        missing: What is not there because the recording was cut off.
        faults: What is damaged.
    """

    missing: List[Message] = field(default_factory=list)
    faults: List[Message] = field(default_factory=list)


def recording_of(survey: Path) -> Path:
    """Return the recording of a survey: of a folder survey.mcap, or survey.bag if there is none.

    Args:
        survey: Folder of a survey, bag or MCAP file.

    Raises:
        AnalysisError: There is none.
    """
    if not survey.exists():
        raise AnalysisError(not_there(survey), fault=faults.NO_INPUT)
    names = (survey_folder.MCAP_FILE, survey_folder.BAG_FILE)
    found = [survey / name for name in names] if survey.is_dir() else [survey]
    for path in found:
        if is_recording(path) and path.is_file():
            return path
    raise AnalysisError(
        Message(
            "{path} has no recording, which this needs: give a survey's folder with {names}, or a "
            "file .mcap or .bag",
            path=survey,
            names=" or ".join(names),
        ),
        fault=faults.NO_INPUT,
    )


def all_messages(path: Path, lost: Lost) -> Iterator[RecordedMessage]:
    """Return the messages of a recording in the order of the file, as far as they are whole.

    Args:
        path: Bag or MCAP file, finished or cut off; it may be a link.
        lost: What could not be read is added here, at the latest when the messages have ended.

    Raises:
        UnreadableFileError: It is neither, or its messages are not those of ROS 1.
        OSError: It cannot be read.
    """
    finished = is_finished(path, follow_link=True)
    if not finished:
        lost.missing.append(CUT_OFF)
    header = None if is_bag(path) else _header(path)
    if header is not None and header.profile != Profile.ROS1:
        raise UnreadableFileError(
            Message(
                "{file} has the profile '{profile}'; only recordings of ROS 1 can be converted",
                file=path.name,
                profile=header.profile,
            ),
            fault=faults.FILE_CONTENT,
        )
    return _noting(
        path, _of_bag(path, finished, lost) if is_bag(path) else _of_mcap(path, header, lost), lost
    )


def _noting(
    path: Path, messages: Iterator[RecordedMessage], lost: Lost
) -> Iterator[RecordedMessage]:
    """Yield messages up to the place where their reader fails."""
    try:
        with failing_as_unreadable(path):
            yield from messages
    except UnreadableFileError as error:
        lost.faults.append(error.message)


def _of_bag(path: Path, finished: bool, lost: Lost) -> Iterator[RecordedMessage]:
    expected, count = 0, 0
    if finished:
        try:
            with failing_as_unreadable(path), bag_reader(path, follow_link=True) as reader:
                expected = reader.message_count
        except UnreadableFileError as error:
            lost.faults.append(error.message)
    # Not by the index: that has another order, and ends at the first damaged chunk.
    with opened(path, follow_link=True) as stream:
        for message in complete_messages(stream):
            count += 1
            yield message
    if count < expected:
        lost.faults.append(
            Message(
                "{file} has {expected} messages by its index, but only {count} could be read",
                file=path.name,
                expected=expected,
                count=count,
            )
        )


def _of_mcap(path: Path, header: Optional[Header], lost: Lost) -> Iterator[RecordedMessage]:
    if header is not None and header.library != LIBRARY:
        return mcap_messages(path, follow_link=True)
    return _stored_messages(path, lost)


def _stored_messages(path: Path, lost: Lost) -> Iterator[RecordedMessage]:
    # It continues behind what is damaged, for which it must know the writer.
    stored = StoredMcap(path.resolve())
    yield from stored.messages()
    # What is damaged at the end looks like the tail of a crash, but for the sums of the whole file.
    lost.faults += stored.faults or stored.frame_faults()


def _header(path: Path) -> Optional[Header]:
    """Return the header of an MCAP file; None if it is damaged."""
    with opened(path, follow_link=True) as stream:
        try:
            return make_reader(stream).get_header()
        except (*TORN, McapError, UnicodeDecodeError):
            return None
