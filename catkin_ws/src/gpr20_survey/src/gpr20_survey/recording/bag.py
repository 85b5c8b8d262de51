"""survey.bag: all of a recording for the tools of ROS 1, made when the survey has ended.

As a program, with a survey's folder as its argument, it makes the bag of that survey.
"""

from __future__ import annotations

import contextlib
import fcntl
import functools
import operator
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any, Dict, Iterable, Tuple

import lz4.frame
from rosbags.rosbag1 import Writer

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import printable, say
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError, storing
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_files import TEMPORARY_PREFIX, open_regular, sum_of_file
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import Fact, add_to_survey
from gpr20_survey.folder.survey_folder import BAG_FILE, MCAP_FILE
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.trace import utc_time

SHOWN = 3  # faults of a recording that are named
# What differs if a recording was written again.
_state_of = operator.attrgetter("st_ino", "st_size", "st_mtime_ns")


class _Writer(Writer):
    """Writes a bag in chunks that stock ROS unpacks, with little memory."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.set_compression(Writer.CompressionFormat.LZ4)
        # ROS's own reader of lz4 knows nothing but independent blocks and a checksum at the end;
        # the library's writer makes others.
        self.compressor = functools.partial(
            lz4.frame.compress, block_linked=False, store_size=False, content_checksum=True
        )

    def write_chunk(self, chunk: Any) -> None:
        """Write a chunk and its index; of that the index of the file needs the lengths alone."""
        for entries in chunk.connections.values():
            entries.sort()  # the clock may have been set back
        super().write_chunk(chunk)
        for number, entries in chunk.connections.items():
            chunk.connections[number] = range(len(entries))


def write_bag(messages: Iterable[RecordedMessage], path: Path) -> int:
    """Write a recording into a new bag; return the number of messages when it is durable.

    Topics, types, times and latching are those that were recorded.

    Args:
        messages: All of the recording.
        path: Must not exist.

    Raises:
        OSError: The recording cannot be read, or the disk refused; the bag is there in part.
    """
    connections: Dict[Tuple[str, str], Any] = {}
    count = 0
    with _Writer(path) as bag:
        os.chmod(str(path), durable_files.file_mode_for(path.parent))
        for message in messages:
            key = (message.topic, message.md5sum)
            if key not in connections:
                connections[key] = bag.add_connection(
                    message.topic,
                    message.datatype.replace("/", "/msg/"),
                    msgdef=message.definition,
                    md5sum=message.md5sum,
                    latching=int(message.latching),
                )
            bag.write(connections[key], message.time_ns, message.data)
            count += 1
    durable_files.sync_path(path)
    return count


def make_bag(folder: Path) -> None:
    """Make survey.bag of a survey that nobody writes, and add its checksum to the log.

    It is whole or not there. A former bag is replaced.

    Args:
        folder: The survey's folder, with a recording, which may be torn if the survey has not
            ended.

    Raises:
        SurveyRefusedError: Another process makes it, the survey was resumed meanwhile, its
            recording is damaged, or nothing can be added to its log.
        StorageFailedError: The disk refused.
    """
    survey_folder.check_no_links(folder)
    bag, mcap = folder / BAG_FILE, StoredMcap(folder / MCAP_FILE)
    temporary = durable_files.temporary_path(bag)

    def put(description: Dict[str, Any]) -> Fact:
        _check_whole(mcap, description.get("ended") is not None, folder)
        if _state_of(mcap.path.stat()) != recorded:
            reason = Message(
                "the survey in {folder} was resumed; its bag is made when it ends",
                folder=printable(folder),
            )
            raise SurveyRefusedError(reason, fault=faults.LOCKED)
        durable_files.put_in_place(temporary, bag)
        return Fact(Kind.BAG, own._asdict())

    failure = Message("{path} could not be written", path=printable(bag))
    with storing(failure, bag), open(open_regular(mcap.path), "rb") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            reason = Message("the bag of {file} is being made already", file=printable(mcap.path))
            raise SurveyRefusedError(reason, fault=faults.LOCKED) from error
        recorded = _state_of(os.fstat(stream.fileno()))
        # What a maker that was killed has left.
        for torn in folder.glob(f"{TEMPORARY_PREFIX}{BAG_FILE}.*"):
            torn.unlink()
        try:
            write_bag(mcap.messages(), temporary)
            own = sum_of_file(temporary)
            now = utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US)
            add_to_survey(folder, put, now)
        finally:
            with contextlib.suppress(FileNotFoundError):
                temporary.unlink()


def _check_whole(mcap: StoredMcap, has_ended: bool, folder: Path) -> None:
    """Refuse a recording that lacks something: its bag would look whole for ever."""
    found = mcap.faults
    if not found and has_ended and not mcap.is_finished():
        found = [
            Message("{file} has no complete end, although the survey ended", file=mcap.path.name)
        ]
    if found:
        raise SurveyRefusedError(
            Message(
                "no bag was made of the survey in {folder}: {faults}; resume the survey, which "
                "repairs its recording, and end it again",
                folder=printable(folder),
                faults=in_a_row(found[:SHOWN]),
            ).reporting_only(faults.CAN_RESUME)
        )


def main() -> int:
    """Make the bag of the survey whose folder is the argument; print why it could not be made."""
    # What ends the process cleans up like Ctrl-C.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        make_bag(Path(sys.argv[1]))
    except Gpr20Error as error:
        say(error.message.to_json())
        return 1
    except KeyboardInterrupt:
        return 1  # who ends it does not ask why
    return 0


if __name__ == "__main__":
    sys.exit(main())
