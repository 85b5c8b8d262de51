"""General-purpose pins with the calls of RPi.GPIO, wired to simulated motors and endstops."""

from __future__ import annotations

from typing import Any, Dict, Iterable, Optional, Protocol, Union


class PinError(RuntimeError):
    """The pins were used in a way that the real ones refuse."""


class Motor(Protocol):
    """What the driver of one axis sees of the machine through its pins."""

    def step(self, forward: bool) -> None:
        """Turn the motor by one step."""

    def endstop_closed(self) -> bool:
        """Return whether the endstop's switch is closed."""

    def note_levels(self, step_high: bool, dir_high: bool) -> None:
        """Take note of the levels of the step and direction pins."""


class SimulatedPins:
    """Stands in for the module RPi.GPIO; a rising edge on a step pin turns the motor.

    The direction pin is high for increasing coordinates. The endstop pulls its pin low.
    """

    BOARD = 10
    OUT = 0
    IN = 1
    LOW = 0
    HIGH = 1
    PUD_UP = 22

    def __init__(
        self, motor: Motor, dir_pin: int, step_pin: int, sensor_pin: Optional[int]
    ) -> None:
        self._motor = motor
        self._dir_pin = dir_pin
        self._step_pin = step_pin
        self._sensor_pin = sensor_pin
        self._numbering: Optional[int] = None
        self._directions: Dict[int, int] = {}
        self._levels: Dict[int, int] = {}

    def setmode(self, mode: int) -> None:
        """Choose the numbering of the pins."""
        if mode != self.BOARD:
            raise PinError(f"pin numbering {mode} is not simulated; use BOARD")
        self._numbering = mode

    def setup(
        self, channel: int, direction: int, initial: Optional[int] = None, pull_up_down: int = 20
    ) -> None:
        """Make a pin an input or an output."""
        if self._numbering is None:
            raise PinError("set the pin numbering with setmode() first")
        self._directions[channel] = direction
        if direction == self.OUT:
            self._levels[channel] = self.LOW if initial is None else initial
            self._note_levels()

    def output(self, channel: int, level: Union[int, bool]) -> None:
        """Drive an output pin."""
        if self._directions.get(channel) != self.OUT:
            raise PinError(f"pin {channel} has not been set up as an output")
        rising = level and not self._levels[channel]
        self._levels[channel] = self.HIGH if level else self.LOW
        self._note_levels()
        if rising and channel == self._step_pin:
            self._motor.step(forward=bool(self._levels.get(self._dir_pin)))

    def input(self, channel: int) -> int:
        """Read a pin."""
        if channel not in self._directions:
            raise PinError(f"pin {channel} has not been set up")
        if self._directions[channel] == self.OUT:
            return self._levels[channel]
        closed = channel == self._sensor_pin and self._motor.endstop_closed()
        return self.LOW if closed else self.HIGH

    def cleanup(self, channel: Union[int, Iterable[int], None] = None) -> Any:
        """Make pins inputs again, as they were before setup."""
        if channel is None:
            channels = list(self._directions)
        else:
            channels = [channel] if isinstance(channel, int) else list(channel)
        for one in channels:
            self._directions.pop(one, None)
            self._levels.pop(one, None)
        # The motor driver pulls its inputs down where nothing drives them.
        self._note_levels()

    def _note_levels(self) -> None:
        step, direction = self._levels.get(self._step_pin), self._levels.get(self._dir_pin)
        self._motor.note_levels(bool(step), bool(direction))
