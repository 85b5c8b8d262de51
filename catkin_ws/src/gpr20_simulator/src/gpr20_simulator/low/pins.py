"""General-purpose pins with the calls of RPi.GPIO, wired to simulated motors and endstops."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Iterable, Optional, Protocol, Union

from gpr20_survey.axes.axis_parameters import Level


class Motor(Protocol):
    """What the driver of one axis sees of the machine through its pins."""

    def step(self, forward: bool) -> None:
        """Turn the motor by one step."""

    def endstop_closed(self) -> bool:
        """Return whether the endstop's switch is closed."""

    def note_levels(self, step_high: bool, dir_high: bool) -> None:
        """Take note of the levels of the step and direction pins."""


@dataclass(frozen=True)
class Wiring:
    """How one axis is wired; pins are BOARD numbers.

    Attributes:
        dir_pin: Direction pin.
        step_pin: Step pin.
        sensor_pin: The endstop's pin; an axis without endstop has none.
        endstop_active: Level to which the endstop's switch connects its pin when it closes. While
            it is open, the level is that of the pull; without a pull of the computer, that of a
            resistor outside it, which is the other level.
        direction_inverted: Whether the direction pin is low for increasing coordinates.
        enable_pin: Enable pin of the motor driver; without one it is always enabled.
        enable_active: Level at which the motor driver is enabled.
    """

    dir_pin: int
    step_pin: int
    sensor_pin: Optional[int]
    endstop_active: Level = Level.LOW
    direction_inverted: bool = False
    enable_pin: Optional[int] = None
    enable_active: Level = Level.LOW


class SimulatedPins:
    """Stands in for the module RPi.GPIO; a rising edge on a step pin turns the motor."""

    BOARD = 10
    OUT = 0
    IN = 1
    LOW = 0
    HIGH = 1
    PUD_OFF = 20
    PUD_DOWN = 21
    PUD_UP = 22

    def __init__(self, motor: Motor, wiring: Wiring) -> None:
        self._motor = motor
        self._wiring = wiring
        self._pulls: Dict[int, int] = {}
        self._directions: Dict[int, int] = {}
        self._levels: Dict[int, int] = {}

    def setmode(self, mode: int) -> None:
        """Choose the numbering of the pins."""
        if mode != self.BOARD:
            raise ValueError(f"pin numbering {mode} is not simulated; use BOARD")

    def setup(
        self,
        channel: int,
        direction: int,
        initial: Optional[int] = None,
        pull_up_down: int = PUD_OFF,
    ) -> None:
        """Make a pin an input or an output."""
        self._directions[channel] = direction
        self._pulls[channel] = pull_up_down
        if direction == self.OUT:
            self._levels[channel] = self.LOW if initial is None else initial
            self._note_levels()

    def output(self, channel: int, level: Union[int, bool]) -> None:
        """Drive an output pin; KeyError: it has not been set up as one."""
        rising = level and not self._levels[channel]
        self._levels[channel] = self.HIGH if level else self.LOW
        self._note_levels()
        if rising and channel == self._wiring.step_pin and self._enabled:
            high = bool(self._levels.get(self._wiring.dir_pin))
            self._motor.step(forward=high != self._wiring.direction_inverted)

    def input(self, channel: int) -> int:
        """Read a pin; KeyError: it has not been set up."""
        if self._directions[channel] == self.OUT:
            return self._levels[channel]
        active = self._level(self._wiring.endstop_active)
        if channel == self._wiring.sensor_pin and self._motor.endstop_closed():
            return active
        pulled = {self.PUD_UP: self.HIGH, self.PUD_DOWN: self.LOW}
        return pulled.get(self._pulls[channel], self.HIGH - active)

    @property
    def _enabled(self) -> bool:
        pin = self._wiring.enable_pin
        # Where nothing drives it, a resistor keeps the motor driver disabled.
        return pin is None or self._levels.get(pin) == self._level(self._wiring.enable_active)

    def _level(self, level: Level) -> int:
        return self.HIGH if level is Level.HIGH else self.LOW

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
        step = self._levels.get(self._wiring.step_pin)
        direction = self._levels.get(self._wiring.dir_pin)
        self._motor.note_levels(bool(step), bool(direction))
