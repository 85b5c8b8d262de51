"""What a replay publishes of a recorded survey, and when: its rate and pauses."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterable, Iterator, Optional

from gpr20_analysis.errors import AnalysisError, DamagedSurveyError
from gpr20_analysis.read.recordings import (
    MCAP,
    Lost,
    all_messages,
    is_metadata_topic,
    mcap_length_s,
    recording_of,
    without_traces,
)
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import storable
from gpr20_survey.folder import survey_metadata
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.recording.survey_topics import METADATA_TOPIC, REPLAY_TYPE
from gpr20_survey.trace import trace_message, utc_time

# A replay that is paused is woken by an event.
PAUSED_WAIT_S = 3600.0
# Shorter waits are none.
RESOLUTION_S = 1e-9


@dataclass(frozen=True)
class ReplayedSurvey:
    """What is known of a survey before its replay begins.

    Attributes:
        survey_id: UUID; empty, as what follows, if it is not known.
        started: Start of the survey, ISO 8601, UTC.
        folder: Name of its folder.
        namespace: Of the robot that recorded it, with a slash at its end.
        length_s: Length of the recording [s]; 0 if it is not known.
    """

    survey_id: str = ""
    started: str = ""
    folder: str = ""
    namespace: str = "/"
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
    """Return what a survey is, by the first messages of its recording.

    Args:
        survey: Folder of a survey, or its recording.

    Raises:
        AnalysisError: It is no recording of a survey; the message names its topics.
        OSError: It cannot be read.
    """
    path = recording_of(survey)
    messages = all_messages(path, Lost())
    one = next((one for one in messages if is_metadata_topic(one.topic) or _is_trace(one)), None)
    if one is None:
        raise without_traces(path)
    described: Dict[str, Any] = {}
    if not _is_trace(one):
        text = one.data[4:].decode("utf-8", "replace")
        described = survey_metadata.parse_object(text, METADATA_TOPIC)
    return ReplayedSurvey(
        survey_id=str(described.get("survey_id", "")),
        started=str(described.get("started", "")),
        folder=storable(survey.resolve().name) if survey.is_dir() else "",
        namespace=one.topic[: one.topic.rindex("/") + 1],
        length_s=mcap_length_s(path) if path.suffix == MCAP else 0.0,
    )


def recorded(survey: Path) -> Iterator[RecordedMessage]:
    """Yield the messages of a survey's recording.

    Raises:
        AnalysisError: It is damaged; messages before the damage are yielded.
        OSError: It cannot be read.
    """
    lost = Lost()
    for message in all_messages(recording_of(survey), lost):
        if message.datatype != REPLAY_TYPE:
            yield message
    if lost.faults:
        raise DamagedSurveyError(in_a_row(lost.faults).reporting_only(DamagedSurveyError.fault))


def _is_trace(message: RecordedMessage) -> bool:
    return message.datatype == trace_message.DATATYPE


class Playback:
    """Gives out messages when they are due. Any thread may pause it and change its rate.

    Attributes:
        rate: How many times faster than it was recorded.
        paused: Whether it is paused.
        ended: Set when it was stopped.
        position_s: Place of the last message, from the start of the recording [s].
    """

    def __init__(self, clock: Clock, rate: float = 1.0, paused: bool = False) -> None:
        """Prepare a playback.

        Args:
            clock: Measures the time.
            rate: How many times faster than it was recorded.
            paused: Whether it begins paused, behind the messages of its first moment.

        Raises:
            AnalysisError: The rate is not allowed.
        """
        self._clock = clock
        self._changed = threading.Event()
        self.ended = threading.Event()
        self.set_rate(rate)
        self.position_s = 0.0
        self.paused = paused
        # Time of the recording by which the next message is overdue [s].
        self._lead_s = 0.0
        # The rate of the time that has passed since the clock was read last.
        self._waiting_rate = rate
        self._looked_s = 0.0

    @property
    def stopped(self) -> bool:
        """Whether it was stopped."""
        return self.ended.is_set()

    def set_paused(self, paused: bool) -> None:
        """Pause, or continue."""
        self.paused = paused
        self._changed.set()

    def set_rate(self, rate: float) -> None:
        """Change the speed.

        Raises:
            AnalysisError: It is not allowed; the former one remains.
        """
        if not 0.0 < rate <= 1e6:
            raise AnalysisError(
                Message("the rate is {rate:g}; it must be more than 0, at most 1e6", rate=rate)
            )
        self.rate = rate
        self._changed.set()

    def stop(self) -> None:
        """Give out nothing more."""
        self.ended.set()
        self._changed.set()

    def play(self, messages: Iterable[RecordedMessage]) -> Iterator[RecordedMessage]:
        """Yield messages when they are due, until stopped.

        Args:
            messages: The whole recording.
        """
        now_ns: Optional[int] = None
        self._looked_s = self._clock.now_s()
        for one in messages:
            # Recorders may swap messages of the same instant: for messages out of order the
            # latest time counts, so that no gap is waited for twice.
            before_ns = one.time_ns if now_ns is None else now_ns
            now_ns = max(before_ns, one.time_ns)
            gap_s = (now_ns - before_ns) / utc_time.NS_PER_S
            if not self._wait(gap_s):
                return
            self.position_s += gap_s
            yield one

    def _wait(self, gap_s: float) -> bool:
        """Wait for a gap of the recording; return False once stopped."""
        self._count_passed()
        self._lead_s -= gap_s
        while not self.ended.is_set():
            self._changed.clear()
            if self.paused and gap_s > 0.0:
                self._clock.wait_s(self._changed, PAUSED_WAIT_S)
                self._looked_s = self._clock.now_s()
            elif self._lead_s >= -RESOLUTION_S:
                return True
            else:
                self._waiting_rate = self.rate
                self._clock.wait_s(self._changed, -self._lead_s / self._waiting_rate)
                self._count_passed()
        return False

    def _count_passed(self) -> None:
        looked_s, self._looked_s = self._looked_s, self._clock.now_s()
        self._lead_s += (self._looked_s - looked_s) * self._waiting_rate
