"""An MCAP file that loses nothing that was committed."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import IO, Dict, Tuple, cast

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import MCAP0_MAGIC, Writer

from gpr20_survey.files.append_only_file import AppendOnlyFile
from gpr20_survey.recording.recording import RecordedMessage, Recording

MAGIC = MCAP0_MAGIC
LIBRARY = "gpr20_vna_processing"
ATTACHMENT = "survey.json"
METADATA = "gpr20.survey"


class McapFile(Recording):
    """Writes messages into an MCAP file of profile ros1 (zstd, with checksums).

    A record of an MCAP file begins with its length, so a file cut anywhere is read up to the cut.
    The library writes into the memory of an `AppendOnlyFile` and never to the disk: what the
    disk refuses is written again by the next commit. It holds the index of the whole file.
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
        super().__init__(AppendOnlyFile(path))
        self._writer = Writer(cast(IO[bytes], self._file), enable_data_crcs=True)
        self._schemas: Dict[Tuple[str, str], int] = {}
        self._channels: Dict[Tuple[str, str], int] = {}
        self._counts: Counter[int] = Counter()
        self._writer.start(Profile.ROS1, LIBRARY)
        self._writer.add_metadata(METADATA, metadata)
        self._writer.add_attachment(time_ns, time_ns, ATTACHMENT, "application/json", attachment)

    def write(self, message: RecordedMessage) -> None:
        """Collect a message."""
        channel = self._channel_of(message)
        self._counts[channel] += 1
        self._writer.add_message(
            channel, message.time_ns, message.data, message.time_ns, self._counts[channel]
        )

    def begin_chunk(self) -> None:
        """End the chunk in progress."""
        self._writer.flush()

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

    def _channel_of(self, message: RecordedMessage) -> int:
        key = (message.topic, message.md5sum)
        if key not in self._channels:
            metadata = {"md5sum": message.md5sum, "latching": "1" if message.latching else "0"}
            self._channels[key] = self._writer.register_channel(
                message.topic, MessageEncoding.ROS1, self._schema_of(message), metadata
            )
        return self._channels[key]

    def _schema_of(self, message: RecordedMessage) -> int:
        key = (message.datatype, message.definition)
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                message.datatype, SchemaEncoding.ROS1, message.definition.encode()
            )
        return self._schemas[key]
