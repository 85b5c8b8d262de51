"""The switch at the end of an axis."""

from __future__ import annotations

from gpr20_axis_driver.low.pins import Pins


class EndstopInterface:
    """Reads an endstop; its pin is pulled up and reads low when the switch is pressed."""

    def __init__(self, pins: Pins, sensor_pin: int) -> None:
        self._pins = pins
        self._sensor_pin = sensor_pin
        pins.setmode(pins.BOARD)
        pins.setup(sensor_pin, pins.IN, pull_up_down=pins.PUD_UP)

    def is_pressed(self) -> bool:
        """Return whether the switch is pressed now."""
        return self._pins.input(self._sensor_pin) == self._pins.LOW

    def close(self) -> None:
        """Release the pin."""
        self._pins.cleanup([self._sensor_pin])
