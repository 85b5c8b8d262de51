"""The calls of RPi.GPIO that an axis uses, and the real library behind them."""

from __future__ import annotations

from typing import Any, List, Optional, Protocol

from gpr20_axis_driver.axis_exceptions import AxisException


class Pins(Protocol):
    """What the drivers use of the module RPi.GPIO."""

    BOARD: int
    OUT: int
    IN: int
    LOW: int
    HIGH: int
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


class PinLibraryError(AxisException, OSError):
    """The pins of this computer cannot be used."""


def raspberry_pi_pins() -> Pins:
    """Return the real pins of a Raspberry Pi.

    Raises:
        PinLibraryError: RPi.GPIO is missing, or this is not a Raspberry Pi.
    """
    try:
        # Only here, because the library exists and works on the robot alone.
        from RPi import GPIO
    except (ImportError, RuntimeError) as error:
        raise PinLibraryError(
            f"the pins cannot be used: {error}; on the robot run scripts/setup.sh --robot, "
            "elsewhere launch with robot:=simulated"
        ) from error
    return GPIO
