"""Making the pulses of a motion one by one, on pins."""

from __future__ import annotations

from typing import Optional, Tuple

from gpr20_axis_driver.low.endstop_interface import EndstopInterface
from gpr20_axis_driver.low.stepper_interface import StepperInterface
from gpr20_axis_driver.mid.motion import (
    Ending,
    LateLimits,
    Lateness,
    Motion,
    MotionReport,
    StepCount,
    StopRequested,
    Until,
)
from gpr20_axis_driver.mid.schedule import Schedule
from gpr20_common.low.clock import Clock


class PulseLoop:
    """Steps a motor against absolute moments; implements `MotionRunner`."""

    def __init__(
        self,
        stepper: StepperInterface,
        endstop: Optional[EndstopInterface],
        clock: Clock,
        limits: LateLimits,
        count: StepCount,
    ) -> None:
        self._stepper = stepper
        self._endstop = endstop
        self._clock = clock
        self._limits = limits
        self._count = count

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor stands.

        A stop ramps down. The steps are counted at the edge on which the motor moves, so
        nothing that ends the motion loses one.
        """
        self._count.begin()
        self._stepper.set_direction(motion.forward)
        start_s = self._clock.now_s()
        schedule = Schedule(motion.ramp, self._limits, start_s)
        try:
            ending, made = self._step_all(motion, schedule, stop_requested)
        finally:
            # Whatever went wrong, the pin does not stay high.
            self._stepper.lower_step()
        if ending is not Ending.GAP:
            self._clock.sleep_until_s(schedule.due_s)
            self._count.rest()
        return MotionReport(
            ending,
            made,
            self._pressed(),
            self._clock.now_s() - start_s,
            schedule.gap_s,
            Lateness.of(schedule.lateness_s, schedule.slowed),
        )

    def close(self) -> None:
        """Leave the pins low and release them."""
        self._stepper.close()
        if self._endstop is not None:
            self._endstop.close()

    def _step_all(
        self, motion: Motion, schedule: Schedule, stop_requested: StopRequested
    ) -> Tuple[Ending, int]:
        change = 1 if motion.forward else -1
        last = motion.steps
        made = 0
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
            self._stepper.raise_step()
            self._count.count(change)
            made += 1
            self._clock.sleep_until_s(schedule.due_s)
            now_s = self._clock.now_s()
            self._stepper.lower_step()
            if schedule.too_late(now_s):
                return Ending.GAP, made
            schedule.fall(now_s)
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
        return self._endstop is not None and self._endstop.is_pressed()
