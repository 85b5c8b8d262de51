"""The step and direction pins of a DRV8825 motor driver."""

from __future__ import annotations

from gpr20_axis_driver.low.pins import Pins
from gpr20_common.low.clock import Clock


class StepperInterface:
    """Turns a motor step by step; the direction pin is high for increasing coordinates."""

    def __init__(self, pins: Pins, dir_pin: int, step_pin: int, clock: Clock) -> None:
        self._pins = pins
        self._dir_pin = dir_pin
        self._step_pin = step_pin
        self._clock = clock
        pins.setmode(pins.BOARD)
        pins.setup(dir_pin, pins.OUT, initial=pins.LOW)
        pins.setup(step_pin, pins.OUT, initial=pins.LOW)

    def set_direction(self, forward: bool) -> None:
        """Choose where the next steps lead; forward means increasing coordinates."""
        self._pins.output(self._dir_pin, self._pins.HIGH if forward else self._pins.LOW)

    def raise_step(self) -> None:
        """Begin a step pulse: the motor moves on this edge."""
        self._pins.output(self._step_pin, self._pins.HIGH)

    def finish_step(self, start_s: float, pause_s: float) -> float:
        """Hold the pulse for a pause, end it and wait for another.

        Waiting for absolute moments keeps one late pulse from delaying all that follow.

        Args:
            start_s: When the pulse was due [s of the clock].
            pause_s: Half of the step's period [s].

        Returns:
            When the next pulse is due [s of the clock].
        """
        self._clock.sleep_until_s(start_s + pause_s)
        self._pins.output(self._step_pin, self._pins.LOW)
        next_s = start_s + 2.0 * pause_s
        self._clock.sleep_until_s(next_s)
        return next_s

    def close(self) -> None:
        """Leave both pins low, then release them."""
        self._pins.output(self._step_pin, self._pins.LOW)
        self._pins.output(self._dir_pin, self._pins.LOW)
        self._pins.cleanup([self._step_pin, self._dir_pin])
