"""An MCAP file that loses nothing that was committed."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import IO, Dict, Tuple, cast

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from gpr20_vna_processing.low.committed_file import CommittedFile
from gpr20_vna_processing.low.recording import RecordedMessage


class McapFile:
    """Writes messages into a new MCAP file of profile ros1 (zstd, with checksums).

    A record of an MCAP file says its length, so a file cut anywhere is read up to the cut.
    """

    def __init__(
        self, path: Path, metadata: Dict[str, str], attachment: bytes, time_ns: int
    ) -> None:
        """Create the file.

        Args:
            path: Must not exist.
            metadata: About the survey, as texts.
            attachment: The survey's description as JSON.
            time_ns: When the survey started [ns since 1970, UTC].

        Raises:
            OSError: The file exists or the disk refused.
        """
        self.name = path.name
        self._channels: Dict[str, int] = {}
        self._schemas: Dict[Tuple[str, str], int] = {}
        self._counts: Counter = Counter()
        self._finished = False
        self._file = CommittedFile(path)
        self._writer = Writer(
            cast(IO[bytes], self._file),
            compression=CompressionType.ZSTD,
            enable_crcs=True,
            enable_data_crcs=True,
        )
        self._writer.start(profile=Profile.ROS1)
        self._writer.add_metadata("gpr20.survey", metadata)
        self._writer.add_attachment(time_ns, time_ns, "survey.json", "application/json", attachment)
        self._file.commit()

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit [bytes]."""
        return self._file.collected_bytes

    def write(self, message: RecordedMessage) -> None:
        """Collect a message."""
        channel = self._channels.get(message.topic)
        if channel is None:
            channel = self._channels[message.topic] = self._register(message)
        self._counts[channel] += 1
        self._writer.add_message(
            channel,
            log_time=message.time_ns,
            publish_time=message.time_ns,
            data=message.data,
            sequence=self._counts[channel],
        )

    def begin_chunk(self) -> None:
        """End the chunk in progress."""
        self._writer.flush()

    def commit(self) -> None:
        """Write everything collected to the disk; return when it is there for good.

        Raises:
            OSError: The disk refused; everything collected is kept for the next commit.
        """
        if self._finished:
            return  # the rest is for `finish`
        self.begin_chunk()
        self._file.commit()

    def finish(self) -> None:
        """Write the summary and close the file.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        if not self._finished:
            self._writer.finish()
            self._finished = True
        self._file.commit()
        self._file.release()

    def abandon(self) -> None:
        """Close the file as it is on the disk; what was not committed is lost."""
        self._file.release()

    def _register(self, message: RecordedMessage) -> int:
        kind = (message.datatype, message.md5sum)
        schema = self._schemas.get(kind)
        if schema is None:
            schema = self._schemas[kind] = self._writer.register_schema(
                message.datatype, SchemaEncoding.ROS1, message.definition.encode()
            )
        metadata = {"md5sum": message.md5sum, "latching": "1" if message.latching else "0"}
        return self._writer.register_channel(message.topic, MessageEncoding.ROS1, schema, metadata)
