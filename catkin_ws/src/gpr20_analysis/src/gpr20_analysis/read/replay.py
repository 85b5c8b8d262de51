"""The messages of a recorded survey that a replay publishes."""

from __future__ import annotations

import itertools
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterable, Iterator, Mapping, NamedTuple, Optional, Union

from gpr20_analysis.errors import DamagedSurveyError
from gpr20_analysis.read.recordings import MCAP, is_metadata_topic, mcap_length_s, mcap_messages
from gpr20_analysis.read.sources import RecordingSource, SurveySource, open_source
from gpr20_common.message import in_a_row
from gpr20_common.terminal_text import storable
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.recording.survey_topics import (
    METADATA_TOPIC,
    REPLAY_TYPE,
    SurveyTopics,
)
from gpr20_survey.trace import trace_message, utc_time
from gpr20_survey.trace.trace import Trace

Content = Union[RecordedMessage, Trace]
FIRST_MESSAGES = 10
"""Of a recording; the metadata of the survey are among them."""


@dataclass(frozen=True)
class Due:
    """A message to publish, and when it was recorded [ns since 1970, UTC]."""

    time_ns: int
    content: Content


class RecordedSurvey(NamedTuple):
    """The survey of a recording.

    Attributes:
        survey_id: UUID.
        started: Start of the survey, ISO 8601, UTC; empty if it is not known.
        folder: Name of its folder; empty if it is not known.
    """

    survey_id: str
    started: str = ""
    folder: str = ""

    @classmethod
    def of(cls, description: Mapping[str, Any], folder: Path) -> RecordedSurvey:
        """Return the survey of a folder, by what its log says."""
        survey_id, started = (str(description.get(key, "")) for key in ("survey_id", "started"))
        return cls(survey_id, started, storable(folder.name))


@dataclass(frozen=True)
class ReplayedSurvey:
    """What is known of a survey before its replay begins.

    Attributes:
        survey: Which one it is.
        namespace: Of the robot that recorded it, with a slash at its end; empty if it is not
            recorded, as in JSON files.
        length_s: Length of the recording [s]; 0 if it is not known.
    """

    survey: RecordedSurvey
    namespace: str = ""
    length_s: float = 0.0

    def name_in(self, namespace: str, name: str) -> str:
        """Return the name of a recorded topic or node in the namespace of a replay.

        Args:
            namespace: Absolute, with a slash at its end.
            name: As it was recorded. What all robots share is, as with `rosbag play --prefix`,
                directly below the first part of the namespace.
        """
        if name.startswith(self.namespace):
            return f"{namespace}{name[len(self.namespace) :]}"
        first = namespace[: namespace.find("/", 1)] if namespace != "/" else ""
        return f"{first}{name}"


def describe(survey: Path) -> ReplayedSurvey:
    """Return what a survey is.

    Raises:
        AnalysisError: It is not a survey, or it is damaged.
        OSError: It cannot be read.
    """
    folder = survey.resolve()
    path, own_name = _mcap(survey), not survey.is_dir()
    if path is None:
        return ReplayedSurvey(_survey_of_files(open_source(survey), folder))
    next(RecordingSource(path).traces(), None)  # refuses a recording of somebody else
    first = itertools.islice(mcap_messages(path, own_name), FIRST_MESSAGES)
    own = next((one for one in first if is_metadata_topic(one.topic)), None)
    description, namespace = {}, "/"
    if own is not None:
        text = own.data[4:].decode("utf-8", "replace")
        description = survey_metadata.parse_object(text, METADATA_TOPIC)
        namespace = own.topic[: own.topic.rindex("/") + 1]
    recorded_survey = RecordedSurvey.of(description, folder if folder.is_dir() else Path())
    return ReplayedSurvey(recorded_survey, namespace, mcap_length_s(path, own_name))


def recorded(survey: Path) -> Iterator[Due]:
    """Yield the messages of a survey in order of time.

    Of a folder its MCAP file is read, which holds every topic of the graph. Without one, or from
    JSON files alone, only what its log says, if there is one, and the traces are yielded. Bags are
    replayed by `rosbag play`.

    Raises:
        AnalysisError: It is not a survey or is damaged; messages before the damage are yielded.
        OSError: It cannot be read.
    """
    path = _mcap(survey)
    if path is not None:
        for message in mcap_messages(path, follow_link=not survey.is_dir()):
            if message.datatype != REPLAY_TYPE:
                yield Due(message.time_ns, message)
        return
    source = open_source(survey)
    described = source.description is not None
    for trace in source.traces():
        time_ns = trace.timestamp_us * utc_time.NS_PER_US
        if described:
            described = False
            text = json.dumps(source.description)
            topics = SurveyTopics(resolve=str)
            yield Due(time_ns, topics.metadata(text, time_ns))
        yield Due(time_ns, trace)
    if source.faults:
        found = in_a_row(fault.message for fault in source.faults)
        raise DamagedSurveyError(found.reporting_only(DamagedSurveyError.fault))


def from_start(items: Iterable[Due], start_s: float) -> Iterator[Due]:
    """Yield what a replay from a later moment publishes, in order of time.

    What was recorded before that moment is due at it, without delay: every trace and the survey's
    metadata, which a map needs, and the last message of each other topic.

    Args:
        items: The whole recording.
        start_s: The moment, from the start of the recording [s].
    """
    start_ns: Optional[int] = None
    last: Dict[str, Content] = {}
    for item in items:
        if start_ns is None:
            start_ns = item.time_ns + round(start_s * utc_time.NS_PER_S)
        if item.time_ns < start_ns:
            content = item.content
            if isinstance(content, Trace) or _is_kept(content):
                yield Due(start_ns, content)
            else:
                # Removed first, so that the topics are in the order of their last messages.
                last.pop(content.topic, None)
                last[content.topic] = content
            continue
        yield from (Due(start_ns, content) for content in last.values())
        last = {}
        yield item
    yield from (Due(start_ns or 0, content) for content in last.values())


def _is_kept(message: RecordedMessage) -> bool:
    return is_metadata_topic(message.topic) or message.datatype == trace_message.DATATYPE


def _mcap(survey: Path) -> Optional[Path]:
    path = survey / survey_folder.MCAP_FILE if survey.is_dir() else survey
    return path if path.suffix == MCAP and os.path.lexists(str(path)) else None


def _survey_of_files(source: SurveySource, folder: Path) -> RecordedSurvey:
    if folder.name == survey_folder.TRACES_FOLDER:
        folder = folder.parent
    if source.description is not None:
        return RecordedSurvey.of(source.description, folder)
    first = next(source.traces(), None)
    return RecordedSurvey("" if first is None else first.survey_id, folder=storable(folder.name))
