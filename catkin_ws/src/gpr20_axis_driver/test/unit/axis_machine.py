"""A machine of one axis, at no cost of time, for the tests of its driver."""

from __future__ import annotations

import dataclasses
import os
from typing import List, Optional, Tuple

from direct_pulses import DirectPulses
from recorded_rpi_gpio import RecordedRpiGpio

from gpr20_axis_driver.low.step_counter import FILE_BYTES, StepCounter
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_common.low.clock import Clock
from gpr20_survey.axes.axis_parameters import AxisParameters

X_PARAMETERS = AxisParameters(
    dir_pin=13,
    step_pin=15,
    sensor_pin=16,
    step_size=0.01,
    min_step=0.0015,
    max_step=0.0050,
    delta_step=0.0001,
    min_coord=0.0,
    max_coord=650.0,
    type="LIN",
)
# Its whole length takes no time to travel.
SHORT = dataclasses.replace(X_PARAMETERS, max_coord=20.0)
Z_PARAMETERS = AxisParameters(
    dir_pin=11,
    step_pin=12,
    step_size=1.8,
    min_step=0.010,
    max_step=0.025,
    delta_step=0.005,
    min_coord=-90.0,
    max_coord=90.0,
    type="ROT",
)


class SteppedClock(Clock):
    """Time passes only in sleeps, each too long by `oversleep_s`."""

    def __init__(self) -> None:
        self.time_s = 0.0
        self.oversleep_s = lambda: 0.0

    def now_s(self) -> float:
        return self.time_s

    def sleep_until_s(self, deadline_s: float) -> None:
        self.time_s = max(self.time_s, deadline_s) + self.oversleep_s()


class Machine(RecordedRpiGpio):
    """The pins of RPi.GPIO with a carriage behind them that records every pulse."""

    def __init__(self, parameters: AxisParameters, clock: Clock, start_steps: int) -> None:
        super().__init__()
        self.parameters = parameters
        self.clock = clock
        self.steps = start_steps
        self.endstop_steps = -100
        self.stuck: Optional[bool] = None
        self.lose_steps = False
        self.pulses: List[Tuple[float, int]] = []
        self.edges_s: List[float] = []

    def output(self, channel, level, /):
        rising = level == self.HIGH and self.levels[channel] == self.LOW
        if channel == self.parameters.step_pin and level != self.levels[channel]:
            self.edges_s.append(self.clock.now_s())
        super().output(channel, level)
        if channel == self.parameters.step_pin and rising:
            direction = 1 if self.levels[self.parameters.dir_pin] == self.HIGH else -1
            self.pulses.append((self.clock.now_s(), direction))
            if not self.lose_steps:
                self.steps += direction

    def input(self, channel, /):
        closed = self.steps <= self.endstop_steps if self.stuck is None else self.stuck
        self.inputs[channel] = self.LOW if closed else self.HIGH
        return super().input(channel)


class Count(StepCounter):
    """The step count, in the memory of this process alone."""

    def __init__(self) -> None:
        descriptor = os.memfd_create("steps")
        os.truncate(descriptor, FILE_BYTES)
        super().__init__(descriptor)
        os.close(descriptor)

    def close(self) -> None:
        pass


class Axis:
    """A driver and the machine that it drives."""

    def __init__(self, parameters: AxisParameters, start_steps: int = 500) -> None:
        self.clock = SteppedClock()
        self.machine = Machine(parameters, self.clock, start_steps)
        count = Count()
        loop = PulseLoop(self.machine, parameters, self.clock, count)
        self.pulses = DirectPulses(loop, count)
        self.driver = AxisDriver(parameters, self.pulses)

    @property
    def pauses_s(self) -> List[float]:
        """Half of the time between one pulse and the next [s]."""
        times = [time_s for time_s, _direction in self.machine.pulses]
        return [(later - earlier) / 2 for earlier, later in zip(times, times[1:])]
