"""The messages of a recorded survey, and when each is due in a replay."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable, Iterator, Optional, Union

from gpr20_analysis.errors import AnalysisError, DamagedSurveyError
from gpr20_analysis.read.recordings import MCAP, mcap_messages
from gpr20_analysis.read.sources import open_source
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_survey.folder import survey_folder
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace.trace import Trace

NS_PER_S = 1_000_000_000
NS_PER_US = 1_000

Content = Union[RecordedMessage, Trace]


@dataclass(frozen=True)
class Due:
    """A message to publish, and when it was recorded [ns since 1970, UTC]."""

    time_ns: int
    content: Content


@dataclass(frozen=True)
class Pace:
    """The speed of a replay.

    Attributes:
        rate: How many times faster than it was recorded.
        longest_pause_s: Longer gaps of the recording are shortened to this [s]; None: they are not.
    """

    rate: float = 1.0
    longest_pause_s: Optional[float] = None

    def __post_init__(self) -> None:
        if not 0.0 < self.rate <= 1e6:
            raise AnalysisError(
                Message("the rate is {rate:g}; it must be more than 0, at most 1e6", rate=self.rate)
            )
        if self.longest_pause_s is not None and not self.longest_pause_s >= 0.0:
            raise AnalysisError(
                Message(
                    "the longest pause is {pause_s:g} s; it must be 0 or more",
                    pause_s=self.longest_pause_s,
                )
            )

    def pause_s(self, before_ns: int, after_ns: int) -> float:
        """Return how long to wait between two messages [s]."""
        # Recorders may swap messages of the same instant: a gap is never negative.
        gap_s = max(0, after_ns - before_ns) / NS_PER_S / self.rate
        return gap_s if self.longest_pause_s is None else min(gap_s, self.longest_pause_s)


def recorded(survey: Path) -> Iterator[Due]:
    """Yield the messages of a survey in order of time.

    Of a folder its MCAP file is read, which holds every topic of the graph. Without one, or from
    JSON files alone, only the traces are yielded. Bags are replayed by `rosbag play`.

    Raises:
        AnalysisError: It is not a survey or is damaged; messages before the damage are yielded.
        OSError: It cannot be read.
    """
    path = survey / survey_folder.MCAP_FILE if survey.is_dir() else survey
    if path.suffix == MCAP and path.exists():
        for message in mcap_messages(path):
            yield Due(message.time_ns, message)
        return
    source = open_source(survey)
    for trace in source.traces():
        yield Due(trace.timestamp_us * NS_PER_US, trace)
    if source.faults:
        raise DamagedSurveyError(in_a_row(fault.message for fault in source.faults))


def paced(
    items: Iterable[Due], pace: Pace, clock: Clock, stopped: threading.Event
) -> Iterator[Content]:
    """Yield the contents when they are due, until stopped."""
    due_s = clock.now_s()
    before_ns: Optional[int] = None
    for item in items:
        if before_ns is not None:
            due_s += pace.pause_s(before_ns, item.time_ns)
        # For messages out of order the latest time counts, so that no gap is waited for twice.
        before_ns = item.time_ns if before_ns is None else max(before_ns, item.time_ns)
        if clock.wait_s(stopped, max(0.0, due_s - clock.now_s())):
            return
        yield item.content
