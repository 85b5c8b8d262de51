"""Making the pulses of a motion one by one, on pins, each edge at its time."""

from __future__ import annotations

import math
from array import array
from typing import Optional, Tuple

from gpr20_axis_driver.low.pins import (
    EndstopInterface,
    Pins,
    StepperInterface,
    enable_motor_driver,
)
from gpr20_axis_driver.low.step_counter import StepCounter
from gpr20_axis_driver.motion import (
    AxisHardware,
    Ending,
    Lateness,
    Motion,
    MotionReport,
    StopRequested,
    Until,
)
from gpr20_common.low.clock import Clock
from gpr20_survey.axes.axis_parameters import AxisParameters, Level, Pull
from gpr20_survey.axes.ramp import Ramp


class EdgeSchedule:
    """Absolute times of a motion's edges, corrected by when each was really made.

    A delay up to the limit is absorbed: the next edges keep their times, so a pause can be
    shorter than its due length by up to that limit, never by more. Beyond the limit all later
    edges are shifted, and the motion continues at the speed that the gap means: no burst follows.
    """

    def __init__(self, ramp: Ramp, late_limit_s: float, gap_limit_s: float, start_s: float) -> None:
        """Begin with the slowest pause.

        Args:
            ramp: Pauses of the steps.
            late_limit_s: Up to here later pulses make up for a delay; beyond it they slow down.
            gap_limit_s: Beyond it a motor above its slowest speed can lose steps.
            start_s: When the first edge is due [s of the clock].
        """
        self.due_s = start_s
        self.pause_s = ramp.max_pause_s
        self.lateness_s = array("d")
        self.slowed = 0
        self.gap_s = 0.0
        self._ramp = ramp
        self._late_limit_s, self._gap_limit_s = late_limit_s, gap_limit_s
        self._height = 0
        self._excess_s = 0.0

    def rise(self, now_s: float, steps_left: int) -> None:
        """Record a rising edge; `due_s` becomes the time of its falling edge.

        Args:
            now_s: When it is made [s of the clock].
            steps_left: How many steps are left, including this one.
        """
        late_s = now_s - self.due_s
        self.lateness_s.append(late_s)
        if late_s > self._late_limit_s:
            self._shift(late_s)
        self._excess_s = 0.0
        self.pause_s = self._ramp.pause_s(min(self._height, steps_left - 1))
        self._height += 1
        self.due_s += self.pause_s

    def fall(self, now_s: float) -> None:
        """Record a falling edge; `due_s` becomes the time of the next rising edge."""
        late_s = now_s - self.due_s
        if late_s > self._late_limit_s:
            self._shift(late_s)
        self.due_s += self.pause_s

    def too_late(self, now_s: float) -> bool:
        """Return whether the motor can have lost steps while it waited for this edge."""
        # At the slowest speed the motor may stop and start on any step.
        if self.pause_s >= self._ramp.max_pause_s:
            return False
        gap_s = self._excess_s + now_s - self.due_s
        if gap_s <= self._gap_limit_s:
            return False
        self.gap_s = gap_s
        return True

    def _shift(self, late_s: float) -> None:
        self.slowed += 1
        self.due_s += late_s
        self._excess_s += late_s
        # The step took two pauses and the delay: it was as slow as this.
        pause_s = self.pause_s + self._excess_s / 2.0
        self._height = min(self._height, self._ramp.height_after(pause_s))


class PulseLoop:
    """Steps a motor at absolute times."""

    def __init__(
        self,
        pins: Pins,
        parameters: AxisParameters,
        clock: Clock,
        counter: StepCounter,
        realtime: bool = True,
    ) -> None:
        """Set up the pins of the axis, step and direction low, and enable its motor driver.

        Args:
            pins: The pins.
            parameters: The axis.
            clock: The clock by which it moves.
            counter: Counts its steps.
            realtime: Whether late pulses are limited. Those of a simulated robot that is faster
                than the real one come as fast as they can be made, and say nothing of a motor.
        """
        self._stepper = StepperInterface(
            pins, parameters.dir_pin, parameters.step_pin, parameters.invert_direction
        )
        if parameters.enable_pin is not None:
            enable_motor_driver(pins, parameters.enable_pin, Level(parameters.enable_active))
        self._endstop: Optional[EndstopInterface] = None
        if parameters.sensor_pin is not None:
            self._endstop = EndstopInterface(
                pins,
                parameters.sensor_pin,
                Level(parameters.endstop_active),
                Pull(parameters.endstop_pull),
            )
        self._clock = clock
        self._late_limit_s = parameters.late_limit_s if realtime else math.inf
        self._gap_limit_s = parameters.gap_limit_s if realtime else math.inf
        self._counter = counter

    @classmethod
    def of(cls, hardware: AxisHardware, counter: StepCounter) -> PulseLoop:
        """Open the pins, step and direction low."""
        pins, realtime = hardware.open_pins(), hardware.realtime
        return cls(pins, hardware.parameters, hardware.clock, counter, realtime)

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor is at rest.

        A stop ramps down. The steps are counted at the edge on which the motor moves, so
        nothing that ends the motion loses one.
        """
        self._counter.begin()
        self._stepper.set_direction(motion.forward)
        start_s = self._clock.now_s()
        schedule = EdgeSchedule(motion.ramp, self._late_limit_s, self._gap_limit_s, start_s)
        ending, made = self._step_all(motion, schedule, stop_requested)
        if ending is not Ending.GAP:
            self._clock.sleep_until_s(schedule.due_s)
            self._counter.rest()
        return MotionReport(
            ending,
            made,
            self._pressed(),
            self._clock.now_s() - start_s,
            schedule.gap_s,
            Lateness.of(schedule.lateness_s, schedule.slowed),
        )

    def read_endstop(self) -> None:
        """Note whether the endstop is pressed now."""
        self._pressed()

    def close(self) -> None:
        """Leave the pins low and release them."""
        self._stepper.close()
        if self._endstop is not None:
            self._endstop.close()

    def _step_all(
        self, motion: Motion, schedule: EdgeSchedule, stop_requested: StopRequested
    ) -> Tuple[Ending, int]:
        change = 1 if motion.forward else -1
        last = motion.steps
        made = 0
        fallen_s = 0.0

        def hold() -> None:
            nonlocal made, fallen_s
            self._counter.count(change)
            made += 1
            self._clock.sleep_until_s(schedule.due_s)
            fallen_s = self._clock.now_s()

        while made < last:
            self._clock.sleep_until_s(schedule.due_s)
            early = self._early_ending(motion)
            if early is not None:
                return early, made
            if last == motion.steps and stop_requested():
                # Braking is a shorter motion: its ramp down begins now.
                braking = motion.ramp.braking_steps(schedule.pause_s) if made else 0
                last = min(last, made + braking)
                if made == last:
                    break
            now_s = self._clock.now_s()
            if schedule.too_late(now_s):
                return Ending.GAP, made
            schedule.rise(now_s, last - made)
            self._stepper.step(hold)
            if schedule.too_late(fallen_s):
                return Ending.GAP, made
            schedule.fall(fallen_s)
        return (Ending.COMPLETE if made == motion.steps else Ending.STOPPED), made

    def _early_ending(self, motion: Motion) -> Optional[Ending]:
        if motion.guarded and self._pressed():
            return Ending.PRESSED
        if motion.until is Until.NOTHING:
            return None
        if self._pressed() == (motion.until is Until.PRESSED):
            return Ending.UNTIL
        return None

    def _pressed(self) -> bool:
        if self._endstop is None:
            return False
        pressed = self._endstop.sample()
        self._counter.note_endstop(pressed)
        return pressed
