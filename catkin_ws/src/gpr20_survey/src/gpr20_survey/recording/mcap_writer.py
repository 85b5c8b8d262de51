"""The recording of a survey while it runs: an MCAP file that loses nothing that was committed."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import IO, Dict, Tuple, cast

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import MCAP0_MAGIC, Writer

from gpr20_survey.files.append_only_file import AppendOnlyFile
from gpr20_survey.recording.recording import RecordedMessage

MAGIC = MCAP0_MAGIC
LIBRARY = "gpr20_vna_processing"


class McapFile:
    """Writes messages into an MCAP file of profile ros1 (zstd, with checksums).

    `write` and `write_alone` only collect; nothing is promised before `commit` returns. After a
    commit that failed everything collected is still there and the next one writes it again.

    A record of an MCAP file begins with its length, so a file cut anywhere is read up to the cut.
    The library writes into the memory of an `AppendOnlyFile` and never to the disk: what the
    disk refuses is written again by the next commit. It holds the index of the whole file.

    A topic has one type. A survey may be resumed with another version of the software, whose
    messages have other definitions; players make one publisher per topic, with the type of its
    first message. Messages of another type are recorded under the name of their topic with the
    beginning of the type's checksum, such as `/control_status_7b530785`.
    """

    def __init__(self, path: Path) -> None:
        """Create the file, which must not exist; its head is on the disk after the first commit.

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

    def write_alone(self, message: RecordedMessage) -> None:
        """Collect a message in a chunk of its own: damage to others does not touch it."""
        self._writer.flush()
        self.write(message)
        self._writer.flush()

    def commit(self) -> None:
        """Write everything collected to the disk; return when it is there for good.

        Raises:
            IrregularFileError: The file was moved, removed or replaced.
            OSError: The disk refused; everything collected remains for the next commit.
        """
        if not self._finishing:
            self._writer.flush()
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
            IrregularFileError: The file was moved, removed or replaced.
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
            kind = (message.datatype, message.definition)
            if kind not in self._schemas:
                self._schemas[kind] = self._writer.register_schema(
                    message.datatype, SchemaEncoding.ROS1, message.definition.encode()
                )
            metadata = {"md5sum": md5sum, "latching": "1" if message.latching else "0"}
            self._channels[key] = self._writer.register_channel(
                topic, MessageEncoding.ROS1, self._schemas[kind], metadata
            )
        return self._channels[key]
