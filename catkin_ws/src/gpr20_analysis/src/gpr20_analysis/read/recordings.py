"""The messages of a bag or an MCAP file, and what could not be read of it.

The recording of a survey is read by its own reader, also where it is cut off or damaged; what
others have written by the standard libraries.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterator, List

from mcap.reader import make_reader
from mcap.well_known import Profile

from gpr20_analysis import errors
from gpr20_analysis.errors import AnalysisError, UnreadableFileError, not_there
from gpr20_common.errors import os_reason
from gpr20_common.message import Message, in_a_row
from gpr20_survey.files.regular_files import open_regular
from gpr20_survey.folder import survey_folder
from gpr20_survey.recording.mcap_reader import TORN, StoredMcap, type_of
from gpr20_survey.recording.mcap_writer import LIBRARY, RecordedMessage
from gpr20_survey.recording.survey_topics import METADATA_TOPIC
from gpr20_survey.trace import utc_time

BAG, MCAP = ".bag", ".mcap"
BAG_MAGIC, MCAP_MAGIC = b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n"
CUT_OFF = Message(
    "the recording was cut off, so it has no complete index; all complete messages before that "
    "place were read"
)


@dataclass
class Lost:
    """What could not be read of a recording.

    Attributes:
        missing: What is not there because the recording was cut off.
        faults: What is damaged.
    """

    missing: List[Message] = field(default_factory=list)
    faults: List[Message] = field(default_factory=list)


def is_metadata_topic(topic: str) -> bool:
    """Return whether a topic holds the survey's metadata, whatever the robot's namespace."""
    return topic.rsplit("/", 1)[-1] == METADATA_TOPIC


def is_recording(path: Path) -> bool:
    """Return whether a name is that of a bag or an MCAP file."""
    # `rosbag record` names a bag that it writes .active.
    return path.name.endswith((BAG, f"{BAG}.active", MCAP))


def recording_of(survey: Path) -> Path:
    """Return the recording of a survey: of a folder survey.mcap, or survey.bag if there is none.

    Args:
        survey: Folder of a survey, bag or MCAP file; a link to a file is followed.

    Raises:
        AnalysisError: There is none.
    """
    if not survey.exists():
        raise AnalysisError(not_there(survey), fault=errors.INPUT)
    names = (survey_folder.MCAP_FILE, survey_folder.BAG_FILE)
    found = [survey / name for name in names] if survey.is_dir() else [survey.resolve()]
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
        fault=errors.INPUT,
    )


def without_traces(path: Path) -> UnreadableFileError:
    """Return the error of a recording that somebody else has made, with its topics."""
    lost = Lost()
    topics = sorted({one.topic for one in all_messages(path, lost)})
    if lost.faults:
        return UnreadableFileError(in_a_row(lost.faults).reporting_only(errors.FILE_DAMAGED))
    return UnreadableFileError(
        Message(
            "{file} contains no readable trace of a survey; its topics are: {topics}",
            file=path.name,
            topics=", ".join(topics) or "-",
        ),
        fault=errors.INPUT,
    )


def all_messages(path: Path, lost: Lost, datatype: str = "") -> Iterator[RecordedMessage]:
    """Yield the messages of a recording as far as they are whole, in the order of the file.

    Args:
        path: Bag or MCAP file, no link.
        lost: What could not be read is added here, at the latest when the messages have ended.
        datatype: Type of the messages; empty: of all types.

    Raises:
        UnreadableFileError: It is neither, a bag without its index, or its messages are not those
            of ROS 1.
        OSError: It cannot be opened.
    """
    with open(open_regular(path), "rb") as stream:
        is_mcap = path.suffix == MCAP
        magic = MCAP_MAGIC if is_mcap else BAG_MAGIC
        start = stream.read(len(magic))
        if start != magic:
            raise UnreadableFileError(
                Message(
                    "{file} is not a {kind} file: it begins differently",
                    file=path.name,
                    kind="MCAP" if is_mcap else "bag",
                ),
                fault=errors.FILE_DAMAGED if magic.startswith(start) else errors.INPUT,
            )
        stream.seek(0)
        messages = (_of_mcap if is_mcap else _of_bag)(path, stream, lost, datatype)
        try:
            yield from messages
        except UnreadableFileError:
            raise
        except OSError as error:
            reason = os_reason(error)
            lost.faults.append(Message("{file}: {reason}", file=path.name, reason=reason))
        except Exception as error:
            # The libraries unpack without checks: damaged bytes raise exceptions of any kind.
            lost.faults.append(
                Message(
                    "{file} is damaged; gpr20 verify shows what of its survey's folder is whole",
                    file=path.name,
                    details=repr(error),
                )
            )


def mcap_length_s(path: Path) -> float:
    """Return the time between the first and the last message of an MCAP file [s]; 0 if unknown.

    Raises:
        OSError: It cannot be opened.
    """
    if not StoredMcap(path).is_finished():
        return 0.0
    with open(open_regular(path), "rb") as stream:
        summary = make_reader(stream).get_summary()
    found = summary and summary.statistics
    return (found.message_end_time - found.message_start_time) / utc_time.NS_PER_S if found else 0.0


def _of_mcap(path: Path, stream: Any, lost: Lost, datatype: str) -> Iterator[RecordedMessage]:
    stored, reader, header = StoredMcap(path), make_reader(stream, validate_crcs=True), None
    with contextlib.suppress(*TORN):
        header = reader.get_header()
    if header is not None and header.profile not in ("", Profile.ROS1):
        raise UnreadableFileError(
            Message(
                "{file} has the profile '{profile}'; only recordings of ROS 1 can be read",
                file=path.name,
                profile=header.profile,
            ),
            fault=errors.INPUT,
        )
    is_finished = stored.is_finished()
    if not is_finished:
        lost.missing.append(CUT_OFF)
    if is_finished and header is not None and header.library != LIBRARY:
        for schema, channel, one in reader.iter_messages():
            if schema is not None and datatype in ("", schema.name):
                own, latching = type_of(schema, channel)
                yield RecordedMessage(*own, one.data, one.log_time, latching)
        return
    yield from stored.messages(datatype)
    lost.faults += stored.faults


def _of_bag(path: Path, stream: Any, _: Lost, datatype: str) -> Iterator[RecordedMessage]:
    from rosbags.rosbag1 import Reader

    # The library opens a name: that of the descriptor is the file that was checked.
    bag = Reader(f"/dev/fd/{stream.fileno()}")
    try:
        bag.open()
    except Exception as error:  # of damaged bytes, of any kind
        raise UnreadableFileError(
            Message("{file} has no complete index", file=path.name, details=repr(error)),
            fault=errors.NO_INDEX,
        ) from error
    try:
        kinds = {one.id: str(one.msgtype).replace("/msg/", "/") for one in bag.connections}
        wanted = [one for one in bag.connections if datatype in ("", kinds[one.id])]
        for one, time_ns, data in bag.messages(wanted) if wanted else ():
            definition: Any = one.msgdef  # by version 0.9 it is the text itself
            yield RecordedMessage(
                one.topic,
                kinds[one.id],
                one.digest,
                getattr(definition, "data", definition),
                bytes(data),
                time_ns,
                getattr(one.ext, "latching", None) == 1,
            )
    finally:
        bag.close()
