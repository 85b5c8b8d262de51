"""The pins of an axis: motor driver, endstop, and the library behind them."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, ClassVar, List, Optional, Protocol

from gpr20_axis_driver.faults import AxisException
from gpr20_common.faults import NOT_SET_UP
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_survey.axes import AxisParameters, Level, Pull

SHARED_MEMORY = Path("/dev/shm")


class Pins(Protocol):
    """What an axis uses of the module RPi.GPIO."""

    BOARD: int
    OUT: int
    IN: int
    LOW: int
    HIGH: int
    PUD_OFF: int
    PUD_DOWN: int
    PUD_UP: int

    def setmode(self, mode: int) -> None:
        """Choose the numbering of the pins."""

    def setup(
        self, channel: int, direction: int, initial: Optional[int] = ..., pull_up_down: int = ...
    ) -> None:
        """Make a pin an input or an output."""

    def output(self, channel: int, level: int) -> None:
        """Drive an output pin."""

    def input(self, channel: int) -> int:
        """Read a pin."""

    def cleanup(self, channel: List[int]) -> Any:
        """Make pins inputs again."""


class StepperInterface:
    """Turns a motor step by step through a DRV8825 motor driver.

    Attributes:
        dir_pin: Direction pin [BOARD number], high for increasing coordinates unless inverted.
        step_pin: Step pin [BOARD number].
    """

    def __init__(self, pins: Pins, dir_pin: int, step_pin: int, inverted: bool = False) -> None:
        self.dir_pin = dir_pin
        self.step_pin = step_pin
        self._pins = pins
        self._inverted = inverted
        pins.setmode(pins.BOARD)
        pins.setup(dir_pin, pins.OUT, initial=pins.LOW)
        pins.setup(step_pin, pins.OUT, initial=pins.LOW)

    def set_direction(self, forward: bool) -> None:
        """Choose the direction of the next steps; forward means increasing coordinates."""
        high = forward != self._inverted
        self._pins.output(self.dir_pin, self._pins.HIGH if high else self._pins.LOW)

    def step(self, hold: Callable[[], object]) -> None:
        """Make one step: the motor moves when the step pin rises.

        Args:
            hold: Called while the step pin is high. The pin is low on return, whatever it raises.
        """
        try:
            self._pins.output(self.step_pin, self._pins.HIGH)
            hold()
        finally:
            self._pins.output(self.step_pin, self._pins.LOW)

    def close(self) -> None:
        """Leave both pins low, then release them."""
        self._pins.output(self.step_pin, self._pins.LOW)
        self._pins.output(self.dir_pin, self._pins.LOW)
        self._pins.cleanup([self.step_pin, self.dir_pin])


class EndstopInterface:
    """Reads the switch at the end of an axis.

    Attributes:
        sensor_pin: The switch's pin [BOARD number].
    """

    def __init__(
        self, pins: Pins, sensor_pin: int, active: Level = Level.LOW, pull: Pull = Pull.UP
    ) -> None:
        """Make the pin an input.

        Args:
            pins: The pins.
            sensor_pin: The switch's pin [BOARD number].
            active: What it reads while the switch is pressed.
            pull: The computer's resistor at it.
        """
        self.sensor_pin = sensor_pin
        self._pins = pins
        self._pressed = _level(pins, active)
        resistors = {Pull.UP: pins.PUD_UP, Pull.DOWN: pins.PUD_DOWN, Pull.NONE: pins.PUD_OFF}
        pins.setmode(pins.BOARD)
        pins.setup(sensor_pin, pins.IN, pull_up_down=resistors[pull])

    def sample(self) -> bool:
        """Return whether the switch is pressed now."""
        return self._pins.input(self.sensor_pin) == self._pressed

    def close(self) -> None:
        """Release the pin."""
        self._pins.cleanup([self.sensor_pin])


def enable_motor_driver(pins: Pins, enable_pin: int, active: Level) -> None:
    """Let the motor driver drive its motor.

    Nothing disables it again, not even the end of the process: a motor without current can be
    turned, and the position would be lost.
    """
    pins.setmode(pins.BOARD)
    pins.setup(enable_pin, pins.OUT, initial=_level(pins, active))


def _level(pins: Pins, level: Level) -> int:
    return pins.HIGH if level is Level.HIGH else pins.LOW


@dataclass(frozen=True)
class RobotHardware:
    """One axis of the Raspberry Pi; an `AxisHardware`."""

    description: ClassVar[Hardware] = Hardware("DRV8825 on rpi_gpio")
    first_steps: ClassVar[Optional[int]] = None
    realtime: ClassVar[bool] = True

    parameters: AxisParameters
    clock: Clock = field(default_factory=Clock)

    @property
    def step_file(self) -> Path:
        """The memory file, or one that is lost when the computer is switched off."""
        if self.parameters.memory_file:
            return Path(self.parameters.memory_file)
        pins = f"{self.parameters.dir_pin}-{self.parameters.step_pin}"
        return SHARED_MEMORY / f"gpr20-axis-{os.getuid()}" / f"pins-{pins}"

    def open_pins(self) -> Pins:
        """Return the real pins of a Raspberry Pi.

        Raises:
            AxisException: RPi.GPIO is missing, or this is not a Raspberry Pi.
        """
        try:
            # Only here, because the library exists and works only on the robot.
            from RPi import GPIO
        except (ImportError, RuntimeError) as error:
            raise AxisException(
                Message(
                    "this computer has no usable pins; on the robot run scripts/setup.sh --robot, "
                    "elsewhere launch with robot:=simulated",
                    details=error,
                ),
                fault=NOT_SET_UP,
            ) from error
        return GPIO
