"""The sweeps of an MS2026C: trigger, wait for the end, read new data."""

from __future__ import annotations

from typing import Callable, List, Optional

from gpr20_common.message import Message
from gpr20_survey.faults import PLAN_NOT_ALLOWED
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaOldDataError,
    VnaSettingError,
    VnaSweepError,
    old_data,
    sweep_not_ended,
)
from gpr20_vna_acquisition.mid.block_parser import whole_number
from gpr20_vna_acquisition.mid.display import Display
from gpr20_vna_acquisition.mid.exchanges import Exchanges
from gpr20_vna_acquisition.mid.ms2026c_commands import (
    CLEAR_AVERAGE,
    PREAMBLE,
    STATUS_QUERY,
    SWEEP_COMPLETE_BIT,
    TRIGGER,
    Preamble,
)
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.sweep_timing import (
    SweepEnd,
    SweepTiming,
    enough_learned,
    has_old_points,
    timed_sweep,
)
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# One message, so that nothing is averaged between the two.
NEW_AVERAGE = f"{CLEAR_AVERAGE};{TRIGGER}"
# Polling more often than this loads the instrument and gains nothing [s].
SHORTEST_POLL_S = 0.0005
POLL_FRACTION = 0.1
# While a duration is learned, it is measured to this part of it.
LEARNING_POLL_FRACTION = 0.01


class Ms2026cSweeps:
    """Takes sweeps with the settings that were made before.

    The instrument shows the end of a sweep by a bit. The manual does not define how soon a trigger
    clears the bit of the sweep before, and the data are those of the display, whatever the bit
    says: see `Display`. So the duration of a sweep is measured first, and a bit that was not seen
    cleared is believed only when the sweep must have ended, and only with data that are new at
    every point and do not change any more.
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
        self._triggers = 1
        # How long one trace takes [s]; None before `learn`.
        self.trace_duration_s: Optional[float] = None
        self.display = Display(exchanges, parameters, deadline)

    def learn(self, settings: SweepSettings) -> None:
        """Measure how long a sweep takes; the instrument must be set up and held.

        Raises:
            VnaSweepError: A sweep did not end in time.
            VnaSettingError: The instrument cannot average as it is set up.
        """
        limit_s = self._parameters.sweep_limit_s(self._parameters.nominal_trace_s(settings))
        self._deadline.extend(2.0 * limit_s)
        self._timing, self._triggers = None, 1
        self.display.begin_set_up(settings)
        ends: List[SweepEnd] = []
        while not enough_learned(ends):
            ends.append(self._sweep_once(settings, None, limit_s))
            # The next one is known to be new by its difference from this one.
            self.display.new_numbers(settings, ends[-1].cleared)
        timing = SweepTiming(ends)
        self._triggers = self._triggers_per_trace(settings, timing)
        self._timing = timing
        self.trace_duration_s = self._triggers * timing.duration_s

    def take(self, settings: SweepSettings) -> Sweep:
        """Return the data of a trace that is triggered now."""
        if self._timing is None:
            self.learn(settings)
        timing = self._timing
        assert timing is not None
        limit_s = self._parameters.sweep_limit_s(timing.duration_s)
        was_settled = self.display.begin_trace()
        started_us, started_s = self._utc_now_us(), self._deadline.now_s()
        try:
            for number in range(self._triggers):
                end = self._sweep_once(settings, timing, limit_s, new_average=number == 0)
            duration_s = self._deadline.now_s() - started_s
            numbers = self.display.new_trace(settings, end.cleared, was_settled)
        except (VnaOldDataError, VnaSweepError):
            # What was learned is in doubt too: the next sweep learns again.
            self._timing = None
            raise
        self.trace_duration_s = self._triggers * timing.duration_s
        return timed_sweep(settings, numbers, started_us, duration_s)

    def _sweep_once(
        self,
        settings: SweepSettings,
        timing: Optional[SweepTiming],
        limit_s: float,
        new_average: bool = True,
    ) -> SweepEnd:
        """Take a sweep, of unknown duration without timing; return when its end is certain."""
        begun_s = self._deadline.now_s()
        averaging = settings.analyzer.averages > 1 and new_average
        self._exchanges.write(NEW_AVERAGE if averaging else TRIGGER)
        stale_bit_s, cleared, late = 0.0, False, False
        while True:
            asked_s = self._deadline.now_s() - begun_s
            status = whole_number(self._exchanges.ask(STATUS_QUERY))
            complete = bool(status & SWEEP_COMPLETE_BIT)
            elapsed_s = self._deadline.now_s() - begun_s
            if complete and (cleared or self._has_surely_ended(settings, timing, asked_s)):
                end = SweepEnd(asked_s, elapsed_s, cleared, stale_bit_s if cleared else 0.0)
                if timing is not None:
                    timing.note(end, late)
                return end
            if elapsed_s >= limit_s:
                raise old_data() if complete else sweep_not_ended(settings.points, limit_s)
            if timing is None:
                pause_s = max(SHORTEST_POLL_S, LEARNING_POLL_FRACTION * elapsed_s)
            elif complete or cleared:
                pause_s = max(SHORTEST_POLL_S, POLL_FRACTION * elapsed_s)
                # A bit of the sweep before clears, or does not matter any more. What this sweep is
                # later than expected, the next ones are expected to take.
                late = late or not complete
                rest_s = timing.surely_ended_s - elapsed_s
                rest_s = rest_s if complete else elapsed_s - timing.expected_s
                pause_s = min(pause_s, max(rest_s, SHORTEST_POLL_S))
                pause_s = min(pause_s, self._parameters.poll_interval_s)
            else:
                pause_s = max(timing.expected_s - elapsed_s, 0.0)
            stale_bit_s = elapsed_s if complete else stale_bit_s
            cleared = cleared or not complete
            self._deadline.pause_s(pause_s)

    def _has_surely_ended(
        self, settings: SweepSettings, timing: Optional[SweepTiming], asked_s: float
    ) -> bool:
        """Return whether a sweep has ended whose bit was not seen cleared."""
        if timing is not None:
            return asked_s >= timing.surely_ended_s
        believed_s = self._parameters.nominal_trace_s(settings) + self._parameters.settle_s
        return self._shows_a_whole_new_sweep(settings, asked_s >= believed_s)

    def _shows_a_whole_new_sweep(self, settings: SweepSettings, overdue: bool) -> bool:
        """Return whether every point is new, and none changes any more."""
        before = self.display.shown
        if before is None:
            return overdue
        numbers = self.display.read(settings)
        if has_old_points(numbers, before, to_the_last=True):
            if not overdue or has_old_points(numbers, before):
                return False
            # The last point may be equal by chance, or its turn comes now.
            self._deadline.pause_s(self._parameters.settle_s)
        return bool((numbers == self.display.read(settings)).all())

    def _triggers_per_trace(self, settings: SweepSettings, timing: SweepTiming) -> int:
        """Return how many sweeps must be triggered until an average is complete.

        The manual does not say whether one trigger makes all sweeps of an average.
        """
        averages = settings.analyzer.averages
        if averages <= 1:
            return 1
        self._exchanges.write(CLEAR_AVERAGE)
        if self._averaged(averages) >= averages:
            raise _not_averaging(averages)
        self._sweep_once(settings, timing, self._parameters.sweep_limit_s(timing.duration_s))
        averaged = self._averaged(averages)
        self.display.look(settings)
        return 1 if averaged >= averages else averages

    def _averaged(self, averages: int) -> int:
        """Return how many sweeps the present average has."""
        answer = self._exchanges.ask_optional_raw(PREAMBLE.query)
        found = None if answer is None else Preamble(answer).number("AVERAGING_COUNT")
        if found is None:
            raise _not_averaging(averages)
        return int(found)


def _not_averaging(averages: int) -> VnaSettingError:
    return VnaSettingError(
        Message(
            "the VNA does not show that it begins a new average of {averages} sweeps for each "
            "trace; set the number of averages to 1",
            averages=averages,
        ),
        fault=PLAN_NOT_ALLOWED,
    )
