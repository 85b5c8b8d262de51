"""When which message of a recorded survey is due again."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable, Iterator, Optional, Union

from gpr20_analysis.errors import AnalysisError, DamagedSurveyError
from gpr20_analysis.read.recordings import MCAP, mcap_messages
from gpr20_analysis.read.sources import open_source
from gpr20_common.low.clock import Clock
from gpr20_survey.folder import survey_folder
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace.trace import Trace

NS_PER_S = 1_000_000_000
NS_PER_US = 1_000

Content = Union[RecordedMessage, Trace]


@dataclass(frozen=True)
class Due:
    """Something to be published, and when it was recorded [ns since 1970, UTC]."""

    time_ns: int
    content: Content


@dataclass(frozen=True)
class Pace:
    """How fast a survey is brought back.

    Attributes:
        rate: How many times faster than it was recorded.
        longest_pause_s: No gap of the recording lasts longer than this [s]; None keeps them.
    """

    rate: float = 1.0
    longest_pause_s: Optional[float] = None

    def __post_init__(self) -> None:
        if not 0.0 < self.rate <= 1e6:
            raise AnalysisError(f"the rate is {self.rate:g}; it must be above 0, up to 1e6")
        if self.longest_pause_s is not None and not self.longest_pause_s >= 0.0:
            raise AnalysisError(
                f"the longest pause is {self.longest_pause_s:g} s; it must be 0 or more"
            )

    def pause_s(self, before_ns: int, after_ns: int) -> float:
        """Return how long to wait between two messages [s]."""
        # Recorders may swap messages of the same instant: never wait backwards.
        gap_s = max(0, after_ns - before_ns) / NS_PER_S / self.rate
        return gap_s if self.longest_pause_s is None else min(gap_s, self.longest_pause_s)


def recorded(survey: Path) -> Iterator[Due]:
    """Yield what a survey recorded, in the order of time.

    A folder gives its MCAP with every topic of the graph; without one, and from JSON files alone,
    the traces come back. A bag needs no help: `rosbag play` does it.

    Raises:
        AnalysisError: It is no survey, or is damaged; what comes before is yielded.
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
        raise DamagedSurveyError("; ".join(fault.text for fault in source.faults))


def paced(
    items: Iterable[Due], pace: Pace, clock: Clock, stopped: threading.Event
) -> Iterator[Content]:
    """Yield the contents when they are due, until stopped."""
    due_s = clock.now_s()
    before_ns: Optional[int] = None
    for item in items:
        if before_ns is not None:
            due_s += pace.pause_s(before_ns, item.time_ns)
        # Of messages out of order the latest time counts, or the gap would be waited twice.
        before_ns = item.time_ns if before_ns is None else max(before_ns, item.time_ns)
        if clock.wait_s(stopped, max(0.0, due_s - clock.now_s())):
            return
        yield item.content
