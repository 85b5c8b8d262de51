"""A recording as a bag of ROS 2, message by message: a folder with MCAP and metadata.yaml."""

from __future__ import annotations

import contextlib
import json
from collections import Counter
from pathlib import Path
from typing import Any, Dict, Optional, Tuple

import yaml
from mcap.writer import Writer

from gpr20_analysis import faults
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.format import ExportFormat, RecordingExport, only_recordings
from gpr20_analysis.progress import Progress
from gpr20_analysis.read.doubts import recording_doubts
from gpr20_analysis.read.recordings import Lost, all_messages, is_metadata_topic, recording_of
from gpr20_analysis.sentences import DOUBTS, kept_doubts, with_sentences
from gpr20_common.message import Message
from gpr20_survey.recording.mcap_writer import RecordedMessage

METADATA, MCAP = "metadata.yaml", ".mcap"
# The last version whose names of qualities are numbers, which readers of every release know.
VERSION = 8
LIBRARY = "gpr20_analysis"
# Keep the last message, reliable, transient local: late subscribers get it. By rmw/types.h.
LATCHED = """\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {sec: 2147483647, nsec: 4294967295}
  lifespan: {sec: 2147483647, nsec: 4294967295}
  liveliness: 1
  liveliness_lease_duration: {sec: 2147483647, nsec: 4294967295}
  avoid_ros_namespace_conventions: false"""
CHANGES = "Header.seq is left out; fields that only ROS 2 has are empty"


def export_recording(survey: Path, path: Path, progress: Progress) -> RecordingExport:
    """Write the recording of a survey as a bag of ROS 2; it is complete or does not exist.

    The messages keep their order and times. What cannot be read is left out and named, also in
    metadata.yaml; so is what is doubted.

    Args:
        survey: Folder of a survey, bag or MCAP file, finished or cut off.
        path: Folder to write; it is replaced.
        progress: Shows the progress.

    Raises:
        AnalysisError: It has no recording of ROS 1, no message of it can be read, or the output
            cannot be written.
        OSError: It cannot be read.
    """
    recording = recording_of(survey)
    lost = Lost()
    messages = progress(all_messages(recording, lost), None)
    with atomic_output(path, recording.stat().st_size) as place:
        place.mkdir()
        bag = _Ros2Bag(place, recording, lost)
        with (place / bag.file_name).open("xb") as stream:
            bag.write(stream, messages)
        if not bag.counts:
            raise UnreadableFileError(
                Message("{file} has no message that can be read", file=recording.name),
                fault=faults.FILE_DAMAGED,
            )
    content = Message(
        "{count} messages of {topics} topics",
        count=sum(bag.counts.values()),
        topics=len(bag.counts),
    )
    return content, with_sentences({}, missing=lost.missing, faults=lost.faults, doubts=bag.doubts)


ROS2 = ExportFormat(
    only_recordings("ros2"),
    holds=(METADATA, f"*{MCAP}"),
    has_own_checksum=True,
    of_recording=export_recording,
)


class _Ros2Bag:
    """Writes one bag.

    Attributes:
        file_name: Name of the MCAP file.
        counts: Number of messages of each channel.
        doubts: What of the survey may not be believed.
    """

    def __init__(self, place: Path, recording: Path, lost: Lost) -> None:
        self.file_name = f"{place.name}_0{MCAP}"
        self.counts: Counter[int] = Counter()
        self._place = place
        self._recording = recording
        self._lost = lost
        self._topics: Dict[int, Dict[str, Any]] = {}
        self._channels: Dict[Tuple[str, str, str], int] = {}
        self._types: Dict[Tuple[str, str], Any] = {}
        self._schemas: Dict[Tuple[str, str], int] = {}
        self._failed: Counter[str] = Counter()
        self._simulated: Optional[bool] = None
        self.doubts = recording_doubts(recording)
        self._first_ns, self._last_ns = 2**63 - 1, 0

    def write(self, stream: Any, messages: Any) -> None:
        """Write the MCAP file, and the metadata beside it."""
        self._writer = Writer(stream, enable_data_crcs=True)
        self._writer.start("ros2", LIBRARY)
        for message in messages:
            self._write_message(message)
        self._lost.faults += [
            Message("{count} messages of {topic} are damaged", count=count, topic=topic)
            for topic, count in sorted(self._failed.items())
        ]
        metadata = self._metadata()
        # So that the MCAP file can be played without its folder.
        own = {"serialized_metadata": yaml.safe_dump(metadata, sort_keys=False)}
        self._writer.add_metadata("rosbag2", own)
        self._writer.finish()
        text = yaml.safe_dump({"rosbag2_bagfile_information": metadata}, sort_keys=False)
        (self._place / METADATA).write_text(text, encoding="utf-8")

    def _write_message(self, message: RecordedMessage) -> None:
        try:
            data = self._type_of(message).message(message.data)
        except Exception:
            # Damaged bytes of a bag, which has no checksums: the library raises anything.
            self._failed[message.topic] += 1
            return
        if self._simulated is None and is_metadata_topic(message.topic):
            self._note_simulated(message.data[4:])
        channel = self._channel_of(message)
        self.counts[channel] += 1
        self._first_ns = min(self._first_ns, message.time_ns)
        self._last_ns = max(self._last_ns, message.time_ns)
        self._writer.add_message(
            channel, message.time_ns, data, message.time_ns, self.counts[channel]
        )

    def _note_simulated(self, description: bytes) -> None:
        with contextlib.suppress(ValueError, AttributeError):
            self._simulated = bool(json.loads(description.decode()).get("simulated"))

    def _type_of(self, message: RecordedMessage) -> Any:
        from gpr20_analysis.formats.ros2_types import Ros2Type  # its import takes 0.1 s

        key = (message.datatype, message.definition)
        if key not in self._types:
            self._types[key] = Ros2Type(*key)
        return self._types[key]

    def _channel_of(self, message: RecordedMessage) -> int:
        key = (message.topic, message.datatype, message.definition)
        if key not in self._channels:
            own = self._type_of(message)
            # ROS 2 too has one type for each topic.
            names = [one["name"] for one in self._topics.values()]
            name = (
                f"{message.topic}_{message.md5sum[:8]}" if message.topic in names else message.topic
            )
            qualities = LATCHED if message.latching else ""
            schema = (own.name, own.definition)
            if schema not in self._schemas:
                self._schemas[schema] = self._writer.register_schema(
                    own.name, "ros2msg", own.definition.encode()
                )
            number = self._writer.register_channel(
                name,
                "cdr",
                self._schemas[schema],
                {"offered_qos_profiles": qualities, "topic_type_hash": own.digest},
            )
            self._channels[key] = number
            self._topics[number] = {
                "name": name,
                "type": own.name,
                "serialization_format": "cdr",
                "offered_qos_profiles": qualities,
                "type_description_hash": own.digest,
            }
        return self._channels[key]

    def _times(self) -> Dict[str, Any]:
        return {
            "starting_time": {"nanoseconds_since_epoch": self._first_ns},
            "duration": {"nanoseconds": max(0, self._last_ns - self._first_ns)},
            "message_count": sum(self.counts.values()),
        }

    def _metadata(self) -> Dict[str, Any]:
        custom = {"made_from": self._recording.name, "changes": CHANGES}
        if self._simulated is not None:
            custom["simulated"] = "true" if self._simulated else "false"
        if self.doubts:
            custom[DOUBTS] = "; ".join(kept_doubts(self.doubts))
        lost = [*self._lost.missing, *self._lost.faults]
        if lost:
            custom["lost"] = "; ".join(map(str, lost))
        return {
            "version": VERSION,
            "storage_identifier": "mcap",
            **self._times(),
            "topics_with_message_count": [
                {"topic_metadata": topic, "message_count": self.counts[number]}
                for number, topic in self._topics.items()
            ],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self.file_name],
            "files": [{"path": self.file_name, **self._times()}],
            "custom_data": custom,
            "ros_distro": "",
        }
