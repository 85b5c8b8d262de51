"""The messages of a bag or an MCAP file, and what could not be read of it.

The recording of a survey is read by its own reader, also where it is cut off or damaged; what
others have written by the standard libraries.
"""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, Iterator, List, Optional, Sequence

from mcap.reader import make_reader
from mcap.records import Header
from mcap.well_known import Profile
from rosbags.rosbag1 import Reader
from rosbags.rosbag1.reader import ReaderError

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError, not_there
from gpr20_common.errors import os_reason
from gpr20_common.message import Message, in_a_row
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.log_record import LogRecord
from gpr20_survey.recording.mcap_reader import TORN, StoredMcap, type_of
from gpr20_survey.recording.mcap_writer import LIBRARY, RecordedMessage
from gpr20_survey.recording.survey_topics import METADATA_TOPIC, TEXT_TYPE, recorded_log
from gpr20_survey.trace import trace_message, utc_time

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


@dataclass
class OpenRecording:
    """An open recording."""

    traces: Iterator[RecordedMessage]
    """Every trace; raises UnreadableFileError behind the last if the file is damaged."""
    metadata: Optional[str]
    """Content of survey.json at the start of the survey."""
    log: Sequence[LogRecord]
    """What was added to the survey's log while it was recorded, as far as it can be read."""
    notes: List[Message]


def is_metadata_topic(topic: str) -> bool:
    """Return whether a topic holds the survey's metadata, whatever the robot's namespace."""
    return topic.rsplit("/", 1)[-1] == METADATA_TOPIC


def is_bag(path: Path) -> bool:
    """Return whether a name is that of a bag; `rosbag record` names one that it writes .active."""
    return path.name.endswith((BAG, f"{BAG}.active"))


def is_recording(path: Path) -> bool:
    """Return whether a name is that of a bag or an MCAP file."""
    return is_bag(path) or path.suffix == MCAP


def is_foreign(path: Path) -> bool:
    """Return whether an MCAP file was written by another program."""
    header = _header(path)
    return header is not None and header.library != LIBRARY


def recording_of(survey: Path) -> Path:
    """Return the recording of a survey: of a folder survey.mcap, or survey.bag if there is none.

    Args:
        survey: Folder of a survey, bag or MCAP file.

    Raises:
        AnalysisError: There is none.
    """
    if not survey.exists():
        raise AnalysisError(not_there(survey), fault=faults.INPUT)
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
        fault=faults.INPUT,
    )


def without_traces(path: Path) -> UnreadableFileError:
    """Return the error of a recording that somebody else has made."""
    topics = sorted({one.topic for one in _messages(path, Lost())})
    message = Message(
        "{file} contains no readable trace of a survey; its topics are: {topics}",
        file=path.name,
        topics=", ".join(topics) or "-",
    )
    return UnreadableFileError(message, fault=faults.INPUT)


def open_recording(path: Path) -> OpenRecording:
    """Open a bag or an MCAP file; the path may be a link.

    Raises:
        UnreadableFileError: It is neither, or a bag without its index.
        OSError: It cannot be read.
    """
    lost = Lost()
    messages = _messages(path, lost, trace_message.DATATYPE)

    def traces() -> Iterator[RecordedMessage]:
        yield from messages
        if lost.faults:
            raise UnreadableFileError(in_a_row(lost.faults).reporting_only(faults.FILE_DAMAGED))

    texts = _messages(path, Lost(), TEXT_TYPE)
    log = [one for one in map(recorded_log, texts) if one is not None]
    return OpenRecording(traces(), _metadata(path), log, lost.missing)


def all_messages(path: Path, lost: Lost) -> Iterator[RecordedMessage]:
    """Return the messages of a recording as far as they are whole.

    Args:
        path: Bag or MCAP file; it may be a link.
        lost: What could not be read is added here, at the latest when the messages have ended.

    Raises:
        UnreadableFileError: It is neither, a bag without its index, or its messages are not those
            of ROS 1.
        OSError: It cannot be read.
    """
    header = None if is_bag(path) else _header(path)
    if header is not None and header.profile != Profile.ROS1:
        raise UnreadableFileError(
            Message(
                "{file} has the profile '{profile}'; only recordings of ROS 1 can be converted",
                file=path.name,
                profile=header.profile,
            ),
            fault=faults.INPUT,
        )
    return _messages(path, lost)


def mcap_messages(path: Path, follow_link: bool) -> Iterator[RecordedMessage]:
    """Yield the messages of an MCAP file in order of time; of a cut-off file, the complete ones.

    Args:
        path: The file.
        follow_link: Whether it may be a symbolic link.

    Raises:
        UnreadableFileError: The file is damaged before its end.
        OSError: It cannot be read.
    """
    if not _is_finished(path, follow_link):
        stored = StoredMcap(path.resolve() if follow_link else path)
        with _failing_as_unreadable(path):
            yield from stored.messages()
        if stored.faults:
            raise UnreadableFileError(in_a_row(stored.faults).reporting_only(faults.FILE_DAMAGED))
        return
    with _failing_as_unreadable(path), _opened(path, follow_link) as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            if schema is not None:
                own, latching = type_of(schema, channel)
                yield RecordedMessage(*own, message.data, message.log_time, latching)


def mcap_length_s(path: Path, follow_link: bool) -> float:
    """Return the time between the first and the last message of an MCAP file [s].

    Of a file that was cut off it is not known: 0.

    Args:
        path: The file.
        follow_link: Whether it may be a symbolic link.

    Raises:
        UnreadableFileError: The file is damaged.
        OSError: It cannot be read.
    """
    if not _is_finished(path, follow_link):
        return 0.0
    with _failing_as_unreadable(path), _opened(path, follow_link) as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    if summary is None or summary.statistics is None:
        return 0.0
    statistics = summary.statistics
    length_ns = max(0, statistics.message_end_time - statistics.message_start_time)
    return length_ns / utc_time.NS_PER_S


def _messages(path: Path, lost: Lost, datatype: str = "") -> Iterator[RecordedMessage]:
    """Return the messages of a type, or all of them; see `all_messages`."""
    if is_bag(path):
        with _open_bag(path):
            pass  # one without its index is refused now
        return _noting(path, _of_bag(path, datatype), lost)
    if not _is_finished(path, follow_link=True):
        lost.missing.append(CUT_OFF)
    elif is_foreign(path):
        messages = mcap_messages(path, follow_link=True)
        return _noting(path, (one for one in messages if datatype in ("", one.datatype)), lost)
    return _noting(path, _of_survey(path, lost, datatype), lost)


def _noting(
    path: Path, messages: Iterator[RecordedMessage], lost: Lost
) -> Iterator[RecordedMessage]:
    """Yield messages up to the place where their reader fails."""
    try:
        with _failing_as_unreadable(path):
            yield from messages
    except UnreadableFileError as error:
        lost.faults.append(error.message)


def _of_survey(path: Path, lost: Lost, datatype: str) -> Iterator[RecordedMessage]:
    stored = StoredMcap(path.resolve())
    yield from stored.messages(datatype)
    lost.faults += stored.faults


def _of_bag(path: Path, datatype: str) -> Iterator[RecordedMessage]:
    with _open_bag(path) as bag:
        wanted = [one for one in bag.connections if datatype in ("", _type_of(one))]
        for one, time_ns, data in bag.messages(wanted) if wanted else ():
            definition: Any = one.msgdef  # by version 0.9 it is the text itself
            yield RecordedMessage(
                one.topic,
                _type_of(one),
                one.digest,
                getattr(definition, "data", definition),
                bytes(data),
                time_ns,
                getattr(one.ext, "latching", None) == 1,
            )


def _type_of(connection: Any) -> str:
    return str(connection.msgtype).replace("/msg/", "/")


def _metadata(path: Path) -> Optional[str]:
    """Return survey.json as it was when the recording began."""
    found = (one for one in _messages(path, Lost(), TEXT_TYPE) if is_metadata_topic(one.topic))
    return next((one.data[4:].decode("utf-8", "replace") for one in found), None)


def _opened(path: Path, follow_link: bool) -> BinaryIO:
    return open(open_regular(path, follow_link), "rb")


def _is_finished(path: Path, follow_link: bool) -> bool:
    """Return whether an MCAP file has its end."""
    with _opened(path, follow_link) as stream:
        _check_magic(path, stream, MCAP_MAGIC, "MCAP")
        stream.seek(max(len(MCAP_MAGIC), stream.seek(0, os.SEEK_END) - len(MCAP_MAGIC)))
        return stream.read() == MCAP_MAGIC


def _check_magic(path: Path, stream: BinaryIO, magic: bytes, kind: str) -> None:
    if stream.read(len(magic)) != magic:
        raise UnreadableFileError(
            Message(
                "{file} is not a {kind} file: it begins differently", file=path.name, kind=kind
            ),
            fault=faults.INPUT,
        )


def _header(path: Path) -> Optional[Header]:
    """Return the header of an MCAP file; None if it is damaged."""
    with _opened(path, follow_link=True) as stream:
        try:
            return make_reader(stream).get_header()
        except TORN:
            return None


@contextlib.contextmanager
def _open_bag(path: Path) -> Iterator[Reader]:
    with _opened(path, follow_link=True) as stream:
        _check_magic(path, stream, BAG_MAGIC, "bag")
        # The library opens a name: that of the descriptor is the file that was checked.
        reader = Reader(f"/dev/fd/{stream.fileno()}")
        with _failing_as_unreadable(path):
            try:
                reader.open()
            except ReaderError as error:
                raise UnreadableFileError(
                    Message(
                        "{file} has no complete index; use the survey's folder, or write the index "
                        "with `rosbag reindex {file}`",
                        file=path.name,
                        details=error,
                    ),
                    fault=faults.FILE_DAMAGED,
                ) from error
        try:
            yield reader
        finally:
            reader.close()


@contextlib.contextmanager
def _failing_as_unreadable(path: Path) -> Iterator[None]:
    """Turn every exception of a reader of recordings into one that names the file."""
    try:
        yield
    except UnreadableFileError:
        raise
    except OSError as error:
        raise UnreadableFileError(
            Message("{file}: {reason}", file=path.name, reason=os_reason(error)),
            fault=faults.FILE_DAMAGED,
        ) from error
    except Exception as error:
        # The libraries unpack without checks: damaged bytes raise exceptions of any kind.
        raise UnreadableFileError(
            Message(
                "{file} is damaged; gpr20 verify tells what of its survey's folder is whole",
                file=path.name,
                details=repr(error),
            ),
            fault=faults.FILE_DAMAGED,
        ) from error
