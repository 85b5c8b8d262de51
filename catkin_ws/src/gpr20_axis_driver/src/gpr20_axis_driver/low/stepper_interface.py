"""The step and direction pins of a DRV8825 motor driver."""

from __future__ import annotations

from gpr20_axis_driver.low.pins import Pins


class StepperInterface:
    """Turns a motor step by step; the direction pin is high for increasing coordinates."""

    def __init__(self, pins: Pins, dir_pin: int, step_pin: int) -> None:
        self._pins = pins
        self._dir_pin = dir_pin
        self._step_pin = step_pin
        pins.setmode(pins.BOARD)
        pins.setup(dir_pin, pins.OUT, initial=pins.LOW)
        pins.setup(step_pin, pins.OUT, initial=pins.LOW)

    def set_direction(self, forward: bool) -> None:
        """Choose where the next steps lead; forward means increasing coordinates."""
        self._pins.output(self._dir_pin, self._pins.HIGH if forward else self._pins.LOW)

    def raise_step(self) -> None:
        """Begin a step pulse: the motor moves on this edge."""
        self._pins.output(self._step_pin, self._pins.HIGH)

    def lower_step(self) -> None:
        """End a step pulse."""
        self._pins.output(self._step_pin, self._pins.LOW)

    def close(self) -> None:
        """Leave both pins low, then release them."""
        self._pins.output(self._step_pin, self._pins.LOW)
        self._pins.output(self._dir_pin, self._pins.LOW)
        self._pins.cleanup([self._step_pin, self._dir_pin])
