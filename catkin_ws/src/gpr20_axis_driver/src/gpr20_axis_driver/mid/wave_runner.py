"""Motions as waves of a few steps each, sent a bounded time ahead."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import IO, Any, Deque, List

from gpr20_axis_driver.low.pigpio_waves import StepWaves
from gpr20_axis_driver.low.step_counter import StepCounter
from gpr20_axis_driver.motion import (
    Ending,
    LateLimits,
    Lateness,
    Motion,
    MotionReport,
    StopRequested,
    Until,
)
from gpr20_common.low.clock import Clock
from gpr20_survey.axes.axis_parameters import AxisParameters

# Two waves of this length, or of one step, are under way: a stop takes effect after them.
WAVE_S = 0.025
POLL_S = 0.002
# A wave that ended this long before its time was never transmitted.
EARLY_S = 0.010


@dataclass(frozen=True)
class _Wave:
    number: int
    steps: int
    duration_s: float


class WaveRunner:
    """Makes the pulses of motions through pigpio; implements `MotionRunner`."""

    def __init__(
        self,
        pigpio: Any,
        lock: IO[bytes],
        parameters: AxisParameters,
        clock: Clock,
        counter: StepCounter,
    ) -> None:
        self._lock = lock
        self._waves = StepWaves(pigpio, parameters)
        self._limits = LateLimits.of(parameters)
        self._clock = clock
        self._counter = counter

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor is at rest."""
        self._counter.begin()
        self._waves.set_direction(motion.forward)
        start_s = self._clock.now_s()
        queue = _WaveQueue(motion, self._waves, self._limits, self._clock, self._counter)
        ending = self._feed(motion, queue, stop_requested)
        if ending in (Ending.GAP, Ending.PRESSED):
            self._waves.halt()
        else:
            self._counter.rest()
        duration_s = self._clock.now_s() - start_s
        return MotionReport(
            ending,
            queue.made,
            self._pressed(),
            duration_s,
            queue.gap_s,
            Lateness(slowed=queue.slowed),
        )

    def read_endstop(self) -> None:
        """Note whether the endstop is pressed now."""
        self._pressed()

    def close(self) -> None:
        """Leave the pins low and release the transmitter for another axis."""
        try:
            self._waves.close()
        finally:
            self._lock.close()

    def _feed(self, motion: Motion, queue: _WaveQueue, stop_requested: StopRequested) -> Ending:
        while True:
            queue.retire()
            if queue.gap_s:
                return Ending.GAP
            if motion.guarded and self._pressed():
                return Ending.PRESSED
            if queue.empty and self._until_holds(motion):
                return Ending.UNTIL
            if stop_requested():
                queue.brake()
            if queue.wants_more:
                queue.send()
            elif queue.empty:
                return Ending.COMPLETE if queue.made == motion.steps else Ending.STOPPED
            else:
                self._clock.sleep_until_s(self._clock.now_s() + POLL_S)

    def _until_holds(self, motion: Motion) -> bool:
        if motion.until is Until.NOTHING:
            return False
        return self._pressed() == (motion.until is Until.PRESSED)

    def _pressed(self) -> bool:
        if not self._waves.has_endstop:
            return False
        pressed = self._waves.is_pressed()
        self._counter.note_endstop(pressed)
        return pressed


class _WaveQueue:
    """The waves of one motion: which are under way, and what comes next."""

    def __init__(
        self,
        motion: Motion,
        waves: StepWaves,
        limits: LateLimits,
        clock: Clock,
        counter: StepCounter,
    ) -> None:
        self.made = 0
        self.slowed = 0
        self.gap_s = 0.0
        self._ramp = motion.ramp
        self._change = 1 if motion.forward else -1
        self._last = motion.steps
        self._planned = motion.steps
        # A switch must be read between two steps, so those steps are sent one by one.
        self._one_by_one = motion.until is not Until.NOTHING
        self._waves = waves
        self._limits = limits
        self._clock = clock
        self._counter = counter
        self._under_way: Deque[_Wave] = deque()
        self._sent = 0
        self._height = 0
        self._pause_s = motion.ramp.max_pause_s
        self._end_s = clock.now_s()

    @property
    def empty(self) -> bool:
        """Whether nothing is being transmitted."""
        return not self._under_way

    @property
    def wants_more(self) -> bool:
        """Whether the next wave should be sent now."""
        depth = 1 if self._one_by_one else 2
        return self._sent < self._last and len(self._under_way) < depth

    def brake(self) -> None:
        """Send only the ramp down after the waves that have been sent."""
        if self._last == self._planned:
            braking = self._ramp.braking_steps(self._pause_s) if self._sent else 0
            self._last = min(self._last, self._sent + braking)

    def send(self) -> None:
        """Send the next wave, unless the motor has been left without pulses for too long."""
        now_s = self._clock.now_s()
        if self.empty and self._sent and not self._resume_after(now_s - self._end_s):
            return
        pauses_us = self._next_pauses_us()
        number = self._waves.send(pauses_us)
        duration_s = 2.0e-6 * sum(pauses_us)
        self._under_way.append(_Wave(number, len(pauses_us), duration_s))
        self._sent += len(pauses_us)
        self._end_s = max(now_s, self._end_s) + duration_s

    def retire(self) -> None:
        """Count the steps of the waves that have been transmitted."""
        if self.empty:
            return
        current = self._waves.current()
        now_s = self._clock.now_s()
        if current is None:
            if self._end_s - now_s > EARLY_S:
                # The daemon dropped a wave: its steps are missing.
                self.gap_s = self._end_s - now_s
            while self._under_way:
                self._finish_first()
        elif len(self._under_way) == 2 and current == self._under_way[1].number:
            self._finish_first()
            # The daemon has its own clock: the drift must not add up over a long move.
            self._end_s = now_s + self._under_way[0].duration_s

    def _finish_first(self) -> None:
        wave = self._under_way.popleft()
        self._counter.count(self._change * wave.steps)
        self.made += wave.steps
        self._waves.delete(wave.number)

    def _resume_after(self, late_s: float) -> bool:
        if self._pause_s >= self._ramp.max_pause_s or late_s <= self._limits.late_s:
            return True
        if late_s > self._limits.gap_s:
            self.gap_s = late_s
            return False
        self.slowed += 1
        reached = self._ramp.height_after(self._pause_s + late_s / 2.0)
        self._height = min(self._height, reached)
        return True

    def _next_pauses_us(self) -> List[int]:
        pauses_us: List[int] = []
        duration_s = 0.0
        while self._sent + len(pauses_us) < self._last:
            left = self._last - self._sent - len(pauses_us)
            self._pause_s = self._ramp.pause_s(min(self._height, left - 1))
            self._height += 1
            pauses_us.append(round(self._pause_s * 1.0e6))
            duration_s += 2.0 * self._pause_s
            if self._one_by_one or duration_s >= WAVE_S:
                break
        return pauses_us
