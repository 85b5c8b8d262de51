"""The recording of a survey while it runs: an MCAP file that loses nothing that was committed."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import IO, Any, Dict, Tuple, cast

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import MCAP0_MAGIC, Writer

from gpr20_survey.files.append_only_file import AppendOnlyFile
from gpr20_survey.folder import survey_metadata
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace import utc_time

MAGIC = MCAP0_MAGIC
LIBRARY = "gpr20_vna_processing"
ATTACHMENT = "survey.json"
METADATA = "gpr20.survey"


class McapFile:
    """Writes messages into an MCAP file of profile ros1 (zstd, with checksums).

    `write` and `begin_chunk` only collect; nothing is promised before `commit` returns. After a
    commit that failed everything collected is still there and the next one writes it again.

    A record of an MCAP file begins with its length, so a file cut anywhere is read up to the cut.
    The library writes into the memory of an `AppendOnlyFile` and never to the disk: what the
    disk refuses is written again by the next commit. It holds the index of the whole file.

    A topic has one type. A survey may be resumed with another version of the software, whose
    messages have other definitions; players make one publisher per topic, with the type of its
    first message. Messages of another type are recorded under the name of their topic with the
    beginning of the type's checksum, such as `/control_status_7b530785`.
    """

    def __init__(
        self, path: Path, metadata: Dict[str, str], attachment: bytes, time_ns: int
    ) -> None:
        """Create the file; its head is on the disk after the first commit.

        Args:
            path: Must not exist.
            metadata: About the survey, as texts.
            attachment: The survey's description as JSON.
            time_ns: When the survey started [ns since 1970, UTC].

        Raises:
            OSError: The file exists or the disk refused.
        """
        self._file = AppendOnlyFile(path)
        self._writer = Writer(cast(IO[bytes], self._file), enable_data_crcs=True)
        self._finishing = False  # the index is collected, nothing else may follow
        self._types: Dict[str, str] = {}  # checksum of the type of each topic
        self._schemas: Dict[Tuple[str, str], int] = {}
        self._channels: Dict[Tuple[str, str], int] = {}
        self._counts: Counter[int] = Counter()
        self._writer.start(Profile.ROS1, LIBRARY)
        self._writer.add_metadata(METADATA, metadata)
        self._writer.add_attachment(time_ns, time_ns, ATTACHMENT, "application/json", attachment)

    @property
    def name(self) -> str:
        """File name, for messages."""
        return self._file.path.name

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit, without the chunk in progress [bytes]."""
        return self._file.collected_bytes

    def in_place(self) -> bool:
        """Return whether the file that is written still has its name."""
        return self._file.in_place()

    def write(self, message: RecordedMessage) -> None:
        """Collect a message."""
        channel = self._channel_of(message)
        self._counts[channel] += 1
        self._writer.add_message(
            channel, message.time_ns, message.data, message.time_ns, self._counts[channel]
        )

    def begin_chunk(self) -> None:
        """End the group of messages that are compressed and indexed together."""
        self._writer.flush()

    def write_alone(self, message: RecordedMessage) -> None:
        """Collect a message in a chunk of its own.

        Readers of traces need not unpack other topics.
        """
        self.begin_chunk()
        self.write(message)
        self.begin_chunk()

    def commit(self) -> None:
        """Write everything collected to the disk; return when it is there for good.

        Raises:
            FileReplacedError: The file was moved, removed or replaced.
            OSError: The disk refused; everything collected remains for the next commit.
        """
        if not self._finishing:
            self.begin_chunk()
            self._file.commit()

    def take_place_of(self, path: Path) -> None:
        """Give the file the name of another, which it replaces; return when that is durable.

        Raises:
            OSError: The disk refused.
        """
        self._file.take_place_of(path)

    def finish(self) -> None:
        """Write the summary and close the file.

        Raises:
            FileReplacedError: The file was moved, removed or replaced.
            OSError: The disk refused; the call may be repeated.
        """
        if not self._finishing:
            self._writer.finish()
            self._finishing = True
        self._file.commit()
        self._file.release()

    def abandon(self) -> None:
        """Close the file as it is on the disk; what was not committed is lost."""
        self._file.release()

    def _channel_of(self, message: RecordedMessage) -> int:
        topic, md5sum = message.topic, message.md5sum
        while self._types.setdefault(topic, md5sum) != md5sum:
            topic = f"{topic}_{md5sum[:8]}"
        key = (topic, md5sum)
        if key not in self._channels:
            metadata = {"md5sum": md5sum, "latching": "1" if message.latching else "0"}
            self._channels[key] = self._writer.register_channel(
                topic, MessageEncoding.ROS1, self._schema_of(message), metadata
            )
        return self._channels[key]

    def _schema_of(self, message: RecordedMessage) -> int:
        key = (message.datatype, message.definition)
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                message.datatype, SchemaEncoding.ROS1, message.definition.encode()
            )
        return self._schemas[key]


def new_mcap(path: Path, description: Dict[str, Any]) -> McapFile:
    """Begin the recording of a survey; it holds the survey's description as it is now.

    Raises:
        OSError: The disk refused.
    """
    texts = {
        key: one if isinstance(one, str) and one.isprintable() else json.dumps(one)
        for key, one in description.items()
    }
    started_ns = utc_time.parse_iso(description["started"]) * utc_time.NS_PER_US
    return McapFile(path, texts, survey_metadata.encode(description), started_ns)
