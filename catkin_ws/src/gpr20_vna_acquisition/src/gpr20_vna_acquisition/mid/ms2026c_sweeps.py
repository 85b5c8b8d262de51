"""The sweeps of an MS2026C: trigger, wait for the end, read data that are all new."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, List, Optional, Sequence

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.trace.sweep import Sweep, SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaDataError,
    VnaOldDataError,
    VnaSweepError,
    old_data,
    sweep_not_ended,
)
from gpr20_vna_acquisition.mid.block_parser import parse_numbers, whole_number
from gpr20_vna_acquisition.mid.exchanges import Exchanges, RequestDeadline
from gpr20_vna_acquisition.mid.ms2026c_commands import (
    DATA_QUERY,
    STATUS_QUERY,
    SWEEP_COMPLETE_BIT,
    TRIGGER,
)
from gpr20_vna_acquisition.mid.trace_quality import has_old_points, timed_sweep
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# Sweeps with which a duration is learned, while they take less than this [s] together.
MOST_LEARNED, LEARNING_S = 3, 1.5
# A bit that was not seen cleared is believed this much later than the sweep must have ended.
DOUBT_FACTOR = 1.1
# Polling more often than this loads the instrument and gains nothing [s].
SHORTEST_POLL_S = 0.0005
LONGEST_POLL_S = 0.01
POLL_FRACTION = 0.1
# While a duration is learned, it is measured to this part of it.
LEARNING_POLL_FRACTION = 0.01


@dataclass(frozen=True)
class SweepEnd:
    """How the end of a sweep was noticed.

    Attributes:
        asked_s: From the trigger to the query that showed the end [s].
        duration_s: From the trigger to the answer of that query [s].
        cleared: Whether the bit of the sweep before was seen cleared first.
        stale_bit_s: How long after the trigger the bit was still that of the sweep before [s].
    """

    asked_s: float
    duration_s: float
    cleared: bool
    stale_bit_s: float


class SweepTiming:
    """How long a sweep takes with the present settings, by some sweeps.

    Attributes:
        expected_s: When to ask for its end, so that the first answer mostly shows it [s].
        duration_s: How long it takes until its end is known [s].
        surely_ended_s: When it has certainly ended, whatever the bit says [s].
    """

    def __init__(self, ends: Sequence[SweepEnd]) -> None:
        # The shortest is the one that the computer disturbed least.
        self.expected_s = min(end.asked_s for end in ends)
        self.duration_s = min(end.duration_s for end in ends)
        stale_s = max(end.stale_bit_s for end in ends)
        self.surely_ended_s = DOUBT_FACTOR * max(end.duration_s for end in ends) + stale_s


class Ms2026cSweeps:
    """Takes sweeps with the settings that were made before.

    The instrument shows the end of a sweep by a bit. The manual defines neither how soon a trigger
    clears the bit of the sweep before, nor whether the display has the data when the bit is set:

    - The duration of a sweep is measured first. A bit that was not seen cleared is believed only
      when the sweep must have ended, and only with data that are the same twice.
    - A trigger waits until nothing older than what is shown can reach the display. Then data of
      which every point is new are those of the sweep. They are proven, later, by being read again.
    """

    def __init__(
        self,
        exchanges: Exchanges,
        parameters: VnaParameters,
        deadline: RequestDeadline,
        utc_now_us: Callable[[], int],
    ) -> None:
        self._exchanges = exchanges
        self._parameters = parameters
        self._deadline = deadline
        self._utc_now_us = utc_now_us
        self._timing: Optional[SweepTiming] = None
        # What the next sweep must differ from, and the answer with it; None if nothing was shown.
        self._shown: Optional[np.ndarray] = None
        self._answer = b""
        # Whether that answer is of a trace and was not read twice yet.
        self.is_unproven = False
        # Whether nothing older than what is shown can still come, and when the last sweep ended.
        self._settled = False
        self._ended_s = 0.0
        # How long one trace takes [s]; None before `learn`.
        self.trace_duration_s: Optional[float] = None

    def learn(self, settings: SweepSettings) -> None:
        """Measure how long a sweep takes; the instrument must be set up and held.

        Raises:
            VnaSweepError: A sweep did not end in time.
        """
        limit_s = self._parameters.sweep_limit_s(self._nominal_s(settings))
        self._deadline.extend(2.0 * limit_s)
        self._timing, self.is_unproven = None, False
        try:
            self._shown = self._read(settings)
        except VnaDataError:
            # Nothing was measured with these settings yet.
            self._shown = None
        ends: List[SweepEnd] = []
        while len(ends) < MOST_LEARNED and sum(end.duration_s for end in ends) < LEARNING_S:
            ends.append(self._sweep_once(settings, limit_s))
            # The next one is known to be new by its difference from this one.
            self._new_numbers(settings, ends[-1].cleared)
        self._timing, self._settled = SweepTiming(ends), False
        self.trace_duration_s = max(1, settings.analyzer.averages) * self._timing.duration_s

    def take(self, settings: SweepSettings) -> Sweep:
        """Return the data of a trace that is triggered now, the mean of as many sweeps as asked."""
        if self._timing is None:
            self.learn(settings)
        timing = self._timing
        assert timing is not None
        limit_s = self._parameters.sweep_limit_s(timing.duration_s)
        self._settle(settings)
        started_us, started_s = self._utc_now_us(), self._deadline.now_s()
        sweeps: List[np.ndarray] = []
        try:
            while len(sweeps) < max(1, settings.analyzer.averages):
                end = self._sweep_once(settings, limit_s, timing)
                sweeps.append(self._new_numbers(settings, end.cleared))
        except (VnaOldDataError, VnaSweepError):
            # What was learned is in doubt too: the next sweep learns again.
            self._timing = None
            raise
        self.is_unproven = True
        # A single one stays as it is, bit for bit.
        numbers = sweeps[0] if len(sweeps) == 1 else np.mean(sweeps, axis=0)
        return timed_sweep(settings, numbers, started_us, self._ended_s - started_s)

    def prove(self, settings: SweepSettings) -> None:
        """Read the data of the last trace again; they must have the same bits.

        Raises:
            VnaOldDataError: They have not: the display followed the end of the sweep too late.
        """
        before = self._answer
        # Data that cannot be read prove nothing: they are read once more.
        self._shown = self._read(settings)
        self.is_unproven, self._settled = False, self._answer == before
        if not self._settled:
            raise VnaOldDataError(
                Message(
                    "the VNA's data changed after they were read; its display followed the end of "
                    "the sweep late"
                )
            )

    def _settle(self, settings: SweepSettings) -> None:
        """Wait until nothing older than what is shown can come."""
        if not self._settled:
            settled_s = self._ended_s + self._parameters.display_settle_s
            self._deadline.pause_s(max(0.0, settled_s - self._deadline.now_s()))
            self._shown = self._read(settings)
        # Until this trace is proven.
        self._settled = self.is_unproven = False

    def _sweep_once(
        self, settings: SweepSettings, limit_s: float, timing: Optional[SweepTiming] = None
    ) -> SweepEnd:
        """Take a sweep, of unknown duration without timing; return when its end is certain."""
        begun_s = self._deadline.now_s()
        self._exchanges.write(TRIGGER)
        stale_bit_s, cleared = 0.0, False
        while True:
            asked_s = self._deadline.now_s() - begun_s
            status = whole_number(self._exchanges.ask(STATUS_QUERY))
            complete = bool(status & SWEEP_COMPLETE_BIT)
            self._ended_s = self._deadline.now_s()
            elapsed_s = self._ended_s - begun_s
            if complete and (cleared or self._has_surely_ended(settings, timing, asked_s)):
                return SweepEnd(asked_s, elapsed_s, cleared, stale_bit_s if cleared else 0.0)
            if elapsed_s >= limit_s:
                raise old_data() if complete else sweep_not_ended(settings.points, limit_s)
            if timing is not None and not complete and not cleared:
                pause_s = max(0.0, timing.expected_s - elapsed_s)
            elif timing is not None:
                # A bit of the sweep before clears, or does not matter any more.
                late_s = elapsed_s - timing.expected_s
                rest_s = timing.surely_ended_s - elapsed_s if complete else late_s
                pause_s = min(POLL_FRACTION * elapsed_s, LONGEST_POLL_S, rest_s)
                pause_s = max(SHORTEST_POLL_S, pause_s)
            else:
                pause_s = max(SHORTEST_POLL_S, LEARNING_POLL_FRACTION * elapsed_s)
            stale_bit_s = elapsed_s if complete else stale_bit_s
            cleared = cleared or not complete
            self._deadline.pause_s(pause_s)

    def _has_surely_ended(
        self, settings: SweepSettings, timing: Optional[SweepTiming], asked_s: float
    ) -> bool:
        """Return whether a sweep has ended whose bit was not seen cleared."""
        if timing is not None:
            return asked_s >= timing.surely_ended_s
        before = self._shown
        if before is None:
            return asked_s >= self._nominal_s(settings) + self._parameters.settle_s
        # Every point is new, and none changes any more.
        numbers = self._read(settings)
        is_new = not has_old_points(numbers, before, to_the_last=True)
        return is_new and np.array_equal(numbers, self._read(settings))

    def _new_numbers(self, settings: SweepSettings, cleared: bool) -> np.ndarray:
        """Return numbers of which every one is new.

        Args:
            settings: With which they were measured.
            cleared: Whether the bit of the sweep before was seen cleared. If not, the data must
                also be the same twice.

        Raises:
            VnaOldDataError: Some stay those of the sweep before.
        """
        limit_s = self._deadline.now_s() + self._parameters.settle_s
        numbers, steady = self._read(settings), cleared
        while True:
            is_old = has_old_points(numbers, self._shown, to_the_last=True)
            if steady and not is_old:
                self._shown = numbers
                return numbers
            if self._deadline.now_s() >= limit_s:
                raise old_data()
            if is_old:
                self._deadline.pause_s(LONGEST_POLL_S)
            again = self._read(settings)
            steady, numbers = cleared or np.array_equal(numbers, again), again

    def _read(self, settings: SweepSettings) -> np.ndarray:
        """Return the numbers that are shown now: real and imaginary part of each point in turn."""
        answer = self._exchanges.ask_raw(DATA_QUERY)
        numbers = parse_numbers(answer, self._parameters.transfer_format, 2 * settings.points)
        self._answer = answer
        return numbers

    def _nominal_s(self, settings: SweepSettings) -> float:
        """Return how long one sweep may be expected to take before it is measured [s]."""
        return self._parameters.nominal_trace_s(settings) / max(1, settings.analyzer.averages)
