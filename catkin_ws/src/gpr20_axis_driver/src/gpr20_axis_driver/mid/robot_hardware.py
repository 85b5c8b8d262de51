"""The axes of the real robot, over one of two libraries."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Optional

from gpr20_axis_driver.low.pigpio_waves import WAVE_LOCK, lock_wave_transmitter, pigpio_daemon
from gpr20_axis_driver.low.pins import raspberry_pi_pins
from gpr20_axis_driver.low.step_counter import StepCounter
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.mid.wave_runner import WaveRunner
from gpr20_axis_driver.motion import LateLimits, MotionRunner
from gpr20_common.low.clock import Clock
from gpr20_common.mid.node_facts import Hardware
from gpr20_survey.axes.axis_parameters import PIGPIO, AxisParameters

SHARED_MEMORY = Path("/dev/shm")


@dataclass(frozen=True)
class RobotHardware:
    """One axis of the Raspberry Pi; an `AxisHardware`."""

    first_steps: ClassVar[Optional[int]] = None
    realtime: ClassVar[bool] = True

    parameters: AxisParameters
    clock: Clock = field(default_factory=Clock)

    @property
    def description(self) -> Hardware:
        """What it is."""
        return Hardware(f"DRV8825 on {self.parameters.backend}")

    @property
    def step_file(self) -> Path:
        """Return the memory file, or one that is lost when the computer is switched off."""
        if self.parameters.memory_file:
            return Path(self.parameters.memory_file)
        pins = f"{self.parameters.dir_pin}-{self.parameters.step_pin}"
        return SHARED_MEMORY / f"gpr20-axis-{os.getuid()}" / f"pins-{pins}"

    def open(self, counter: StepCounter) -> MotionRunner:
        """Open the pins; called in the process that makes the pulses."""
        if self.parameters.backend == PIGPIO:
            lock = lock_wave_transmitter(WAVE_LOCK)
            return WaveRunner(pigpio_daemon(), lock, self.parameters, self.clock, counter)
        limits = LateLimits.of(self.parameters)
        return PulseLoop(raspberry_pi_pins(), self.parameters, self.clock, limits, counter)
