"""When the messages of a replay are due: its rate, pauses and start."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Iterable, Iterator, Optional

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.replay import Content, Due, from_start
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.trace import utc_time

LONGEST_START_S = 1e9
# A replay that is paused is woken by an event.
PAUSED_WAIT_S = 3600.0
# Shorter waits are none.
RESOLUTION_S = 1e-9


def checked_rate(rate: float) -> float:
    """Return the rate of a replay.

    Raises:
        AnalysisError: No replay can have it.
    """
    if not 0.0 < rate <= 1e6:
        raise AnalysisError(
            Message("the rate is {rate:g}; it must be more than 0, at most 1e6", rate=rate)
        )
    return rate


@dataclass(frozen=True)
class Pace:
    """The speed of a replay.

    Attributes:
        rate: How many times faster than it was recorded.
        longest_pause_s: Longer gaps of the recording are shortened to this [s]; None: they are not.
        start_s: Where it begins, from the start of the recording [s].
        paused: Whether it begins paused, behind the messages of its first moment.
    """

    rate: float = 1.0
    longest_pause_s: Optional[float] = None
    start_s: float = 0.0
    paused: bool = False

    def __post_init__(self) -> None:
        checked_rate(self.rate)
        if self.longest_pause_s is not None and not self.longest_pause_s >= 0.0:
            raise AnalysisError(
                Message(
                    "the longest pause is {pause_s:g} s; it must be 0 or more",
                    pause_s=self.longest_pause_s,
                )
            )
        if not 0.0 <= self.start_s <= LONGEST_START_S:
            raise AnalysisError(
                Message(
                    "the start is {start_s:g} s; it must be between 0 and {most_s:g}",
                    start_s=self.start_s,
                    most_s=LONGEST_START_S,
                )
            )


class Playback:
    """Gives out messages when they are due. Any thread may pause it and change its rate.

    Attributes:
        ended: Set when it was stopped.
    """

    def __init__(self, pace: Pace, clock: Clock) -> None:
        self._clock = clock
        self._longest_pause_s = pace.longest_pause_s
        self._start_s = pace.start_s
        self._changed = threading.Event()
        self.ended = threading.Event()
        self._rate = pace.rate
        self._paused = pace.paused
        self._position_s = pace.start_s
        # Time of the recording by which the next message is overdue [s].
        self._lead_s = 0.0
        # The rate of the time that has passed since the clock was read last.
        self._waiting_rate = pace.rate
        self._looked_s = 0.0

    @property
    def rate(self) -> float:
        """How many times faster than it was recorded."""
        return self._rate

    @property
    def paused(self) -> bool:
        """Whether it is paused."""
        return self._paused

    @property
    def stopped(self) -> bool:
        """Whether it was stopped."""
        return self.ended.is_set()

    @property
    def position_s(self) -> float:
        """Place of the last message, from the start of the recording [s]."""
        return self._position_s

    def set_paused(self, paused: bool) -> None:
        """Pause, or continue."""
        self._paused = paused
        self._changed.set()

    def set_rate(self, rate: float) -> None:
        """Change the speed.

        Raises:
            AnalysisError: It is not allowed; the former one remains.
        """
        self._rate = checked_rate(rate)
        self._changed.set()

    def stop(self) -> None:
        """Give out nothing more."""
        self.ended.set()
        self._changed.set()

    def play(self, items: Iterable[Due]) -> Iterator[Content]:
        """Yield the contents when they are due, until stopped.

        Args:
            items: The whole recording, in order of time.
        """
        now_ns: Optional[int] = None
        self._looked_s = self._clock.now_s()
        for item in from_start(items, self._start_s):
            # Recorders may swap messages of the same instant: for messages out of order the
            # latest time counts, so that no gap is waited for twice.
            if now_ns is None:
                now_ns = item.time_ns
            gap_s = max(0, item.time_ns - now_ns) / utc_time.NS_PER_S
            if not self._wait(gap_s):
                return
            now_ns = max(now_ns, item.time_ns)
            self._position_s += gap_s
            yield item.content

    def _wait(self, gap_s: float) -> bool:
        """Wait for a gap of the recording; return False once stopped."""
        self._count_passed()
        if self._longest_pause_s is None:
            self._lead_s -= gap_s
        else:
            self._lead_s -= min(gap_s, self._longest_pause_s * self._rate)
        while not self.ended.is_set():
            self._changed.clear()
            if self._paused and gap_s > 0.0:
                self._clock.wait_s(self._changed, PAUSED_WAIT_S)
                self._looked_s = self._clock.now_s()
            elif self._lead_s >= -RESOLUTION_S:
                return True
            else:
                self._waiting_rate = self._rate
                self._clock.wait_s(self._changed, -self._lead_s / self._waiting_rate)
                self._count_passed()
        return False

    def _count_passed(self) -> None:
        looked_s, self._looked_s = self._looked_s, self._clock.now_s()
        self._lead_s += (self._looked_s - looked_s) * self._waiting_rate
