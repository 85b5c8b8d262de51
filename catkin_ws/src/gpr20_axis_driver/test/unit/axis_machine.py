"""Axes for tests: one of this process, which costs no time, and one with a process of its own."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

from robot_parts import DirectPulses

from gpr20_axis_driver.low.step_counter import FILE_BYTES, StepCounter
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.mid.pulse_process import PulseProcess
from gpr20_common.low.clock import Clock
from gpr20_common.low.yaml_file import read_yaml
from gpr20_common.mid.codec import record_from
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.carriage import SimulatedHardware
from gpr20_simulator.mid.world.scene import X_AXIS, Z_AXIS
from gpr20_survey.axes import AxisId, AxisParameters

LIMIT_S = 100.0
AXES = read_yaml(Path(__file__).parents[3] / "gpr20_launch/config/axes.yaml")
X_PARAMETERS, Z_PARAMETERS = (record_from(AxisParameters, AXES[one], one) for one in "xz")
# Its whole length takes no time to travel.
SHORT = dataclasses.replace(X_PARAMETERS, max_coord=20.0)


class SteppedClock(Clock):
    """Time passes only in sleeps, each too long by `oversleep_s`."""

    def __init__(self) -> None:
        self.time_s = 0.0
        self.oversleep_s = lambda: 0.0

    def now_s(self) -> float:
        return self.time_s

    def sleep_until_s(self, deadline_s: float) -> None:
        self.time_s = max(self.time_s, deadline_s) + self.oversleep_s()


class RecordedRpiGpio:
    """A recorder in place of the module RPi.GPIO, which accepts what version 0.7.1 accepts.

    Names, order and defaults of the arguments, the numbers of the constants and the refusals are
    those of its source (py_gpio.c, constants.h). `input` and `output` take no keywords there.
    """

    BOARD, BCM, OUT, IN, LOW, HIGH = 10, 11, 0, 1, 0, 1
    PUD_OFF, PUD_DOWN, PUD_UP = 20, 21, 22

    def __init__(self) -> None:
        self.calls: List[Tuple[Any, ...]] = []
        self.levels: Dict[int, int] = {}
        self.directions: Dict[int, int] = {}
        self.mode: int = -1

    def setmode(self, mode, /):
        if mode not in (self.BOARD, self.BCM):
            raise ValueError("An invalid mode was passed to setmode()")
        if self.mode not in (-1, mode):
            raise ValueError("A different mode has already been set!")
        self.mode = mode
        self.calls.append(("setmode", mode))

    def setup(self, channel, direction, pull_up_down=PUD_OFF, initial=-1):
        assert self.mode == self.BOARD, "Please set pin numbering mode using GPIO.setmode"
        if not all(isinstance(one, int) for one in (channel, direction, pull_up_down, initial)):
            raise TypeError("an integer is required")
        if direction == self.OUT and pull_up_down != self.PUD_OFF:
            raise ValueError("pull_up_down parameter is not valid for outputs")
        if direction == self.IN and initial != -1:
            raise ValueError("initial parameter is not valid for inputs")
        self.calls.append(("setup", channel, direction, pull_up_down, initial))
        self.directions[channel] = direction
        if initial in (self.LOW, self.HIGH):
            self.levels[channel] = initial

    def output(self, channel, value, /):
        if self.directions.get(channel) != self.OUT:
            raise RuntimeError("The GPIO channel has not been set up as an OUTPUT")
        self.calls.append(("output", channel, value))
        self.levels[channel] = int(value)

    def input(self, channel, /):
        if channel not in self.directions:
            raise RuntimeError("You must setup() the GPIO channel first")
        return self.HIGH

    def cleanup(self, channel=None):
        if not isinstance(channel, (int, list, tuple)):
            raise ValueError("Channel must be an integer or list/tuple of integers")
        self.calls.append(("cleanup", channel))
        for one in [channel] if isinstance(channel, int) else channel:
            self.directions.pop(one)


class Machine(RecordedRpiGpio):
    """The pins of RPi.GPIO, wired as these parameters say, with a carriage that records pulses."""

    def __init__(self, parameters: AxisParameters, clock: Clock, start_steps: int) -> None:
        super().__init__()
        self.parameters, self.clock, self.steps = parameters, clock, start_steps
        self.endstop_steps = -100
        self.stuck: Optional[bool] = None
        self.lose_steps = False
        self.pulses: List[Tuple[float, int]] = []
        self.edges_s: List[float] = []

    def output(self, channel, level, /):
        changed = channel == self.parameters.step_pin and level != self.levels[channel]
        super().output(channel, level)
        if changed:
            self.edges_s.append(self.clock.now_s())
        if changed and level == self.HIGH:
            backward = self.levels[self.parameters.dir_pin] == self.parameters.invert_direction
            direction = -1 if backward else 1
            self.pulses.append((self.clock.now_s(), direction))
            self.steps += 0 if self.lose_steps or not self.enabled else direction

    @property
    def enabled(self) -> bool:
        high = self.levels.get(self.parameters.enable_pin, self.LOW) == self.HIGH
        return high == (self.parameters.enable_active == "high")

    def input(self, channel, /):
        opened = super().input(channel) if self.parameters.endstop_active == "low" else self.LOW
        closed = self.steps <= self.endstop_steps if self.stuck is None else self.stuck
        return 1 - opened if closed else opened


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

    def __init__(
        self, parameters: AxisParameters, start_steps: int = 500, wired: Any = None
    ) -> None:
        self.clock = SteppedClock()
        self.machine = Machine(wired or parameters, self.clock, start_steps)
        count = Count()
        loop = PulseLoop(self.machine, parameters, self.clock, count)
        self.pulses = DirectPulses(loop, count)
        self.driver = AxisDriver(parameters, self.pulses)

    @property
    def pauses_s(self) -> List[float]:
        """Half of the time between one pulse and the next [s]."""
        times = [time_s for time_s, _direction in self.machine.pulses]
        return [(later - earlier) / 2 for earlier, later in zip(times, times[1:])]


class SimulatedAxis:
    """A driver whose pulses a real process makes in a world in a folder, and the truth."""

    def __init__(self, folder: Path, axis: AxisId, time_scale: float) -> None:
        self.axis = axis
        self.world = open_shared_state(folder / "world", {AxisId.X: 200})
        of_x = axis is AxisId.X
        parameters, mechanics = (X_PARAMETERS, X_AXIS) if of_x else (Z_PARAMETERS, Z_AXIS)
        path, start = folder / "world", self.world.steps(axis)
        self.pulses = PulseProcess(
            SimulatedHardware(parameters, path, axis, mechanics, time_scale, start)
        )
        self.driver = AxisDriver(parameters, self.pulses)

    @property
    def true_steps(self) -> int:
        return self.world.steps(self.axis)

    @property
    def pins_low(self) -> bool:
        return self.world.pins_low(self.axis)
