"""Step pulses timed by DMA, by the daemon of the library pigpio (version 1.78).

The daemon transmits one wave at a time for the whole computer, so only one axis can use it.
"""

from __future__ import annotations

import fcntl
import os
import struct
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, Iterator, List, Optional, Sequence

from gpr20_axis_driver.axis_exceptions import PinLibraryError, PulseProcessError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_survey.axes.axis_parameters import AxisParameters, Level, Pull

# GPIO numbers, which pigpio uses, of the pins of the 40-pin header (Raspberry Pi 4).
GPIO_OF_BOARD = {
    **{3: 2, 5: 3, 7: 4, 8: 14, 10: 15, 11: 17, 12: 18, 13: 27, 15: 22, 16: 23, 18: 24, 19: 10},
    **{21: 9, 22: 25, 23: 11, 24: 8, 26: 7, 27: 0, 28: 1, 29: 5, 31: 6, 32: 12, 33: 13, 35: 19},
    **{36: 16, 37: 26, 38: 20, 40: 21},
}
# Each wave takes this part of the daemon's memory [%], so that a new one fits where an
# old one was deleted while another is being transmitted.
WAVE_PART = 20
WAVE_LOCK = Path(tempfile.gettempdir()) / f"gpr20-pigpio-waves-{os.getuid()}.lock"


def pigpio_daemon() -> Any:
    """Return the library.

    Raises:
        PinLibraryError: It is not installed.
    """
    try:
        # Only here, because it is installed only where a robot uses it.
        import pigpio
    except ImportError as error:
        raise PinLibraryError(
            Message(
                "backend pigpio cannot be used because its library is missing; on the robot run "
                "scripts/setup.sh --robot and start the daemon pigpiod, or set backend to rpi_gpio",
                details=error,
            )
        ) from error
    return pigpio


def lock_wave_transmitter(path: Path) -> IO[bytes]:
    """Reserve the one transmitter for this process, until the file is closed.

    Raises:
        PinLibraryError: Another axis has it.
    """
    file = path.open("ab")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise PinLibraryError(
            Message(
                "another axis already uses pigpio, which can serve only one axis; set backend to "
                "pigpio for one axis and rpi_gpio for the others"
            ),
            fault=CONFIGURATION,
        ) from None
    return file


class StepWaves:
    """The pins of one axis, its step pin driven by waves of whole steps."""

    def __init__(self, pigpio: Any, parameters: AxisParameters) -> None:
        """Connect, leave step and direction low, and enable the motor driver.

        Args:
            pigpio: The library.
            parameters: The axis; its pins and how they are wired.

        Raises:
            PinLibraryError: The daemon does not answer.
        """
        self._pigpio = pigpio
        self._parameters = parameters
        self._dir = GPIO_OF_BOARD[parameters.dir_pin]
        self._step = GPIO_OF_BOARD[parameters.step_pin]
        sensor_pin = parameters.sensor_pin
        self._sensor = None if sensor_pin is None else GPIO_OF_BOARD[sensor_pin]
        self._pressed = _level(parameters.endstop_active)
        self._pi = pigpio.pi(show_errors=False)
        if not self._pi.connected:
            raise PinLibraryError(
                Message(
                    "the daemon pigpiod does not answer; start it (systemctl start pigpiod) or set "
                    "backend to rpi_gpio"
                ),
                fault=CONFIGURATION,
            )
        with self._errors():
            self._set_up()

    def set_direction(self, forward: bool) -> None:
        """Choose the direction of the next steps; forward means increasing coordinates."""
        with self._errors():
            self._pi.write(self._dir, int(forward != self._parameters.invert_direction))

    @property
    def has_endstop(self) -> bool:
        """Whether there is an endstop to read."""
        return self._sensor is not None

    def is_pressed(self) -> bool:
        """Return whether the endstop is pressed now."""
        with self._errors():
            return self._pi.read(self._sensor) == self._pressed

    def send(self, pauses_us: Sequence[int]) -> int:
        """Transmit steps after the wave that is being transmitted; return the wave's number.

        Args:
            pauses_us: Half of each step's period [us].
        """
        mask = 1 << self._step
        pulses: List[Any] = []
        for pause_us in pauses_us:
            pulses.append(self._pigpio.pulse(mask, 0, pause_us))
            pulses.append(self._pigpio.pulse(0, mask, pause_us))
        with self._errors():
            self._pi.wave_add_generic(pulses)
            wave = self._pi.wave_create_and_pad(WAVE_PART)
            self._pi.wave_send_using_mode(wave, self._pigpio.WAVE_MODE_ONE_SHOT_SYNC)
        return wave

    def delete(self, wave: int) -> None:
        """Free the daemon's memory of a wave that has been transmitted."""
        with self._errors():
            self._pi.wave_delete(wave)

    def current(self) -> Optional[int]:
        """Return the wave that is being transmitted; None if none is."""
        with self._errors():
            wave = self._pi.wave_tx_at()
        return None if wave == self._pigpio.NO_TX_WAVE else wave

    def halt(self) -> None:
        """End the transmission in the middle of a wave; the count of its steps is lost."""
        with self._errors():
            self._pi.wave_tx_stop()
            self._pi.wave_clear()
            self._pi.write(self._step, 0)

    def close(self) -> None:
        """Leave step and direction low and disconnect; the motor driver stays enabled."""
        self.halt()
        with self._errors():
            self._pi.write(self._dir, 0)
        self._pi.stop()

    def _set_up(self) -> None:
        self._pi.wave_tx_stop()
        self._pi.wave_clear()
        for gpio in (self._dir, self._step):
            self._pi.set_mode(gpio, self._pigpio.OUTPUT)
            self._pi.write(gpio, 0)
        if self._parameters.enable_pin is not None:
            enable = GPIO_OF_BOARD[self._parameters.enable_pin]
            self._pi.set_mode(enable, self._pigpio.OUTPUT)
            self._pi.write(enable, _level(self._parameters.enable_active))
        if self._sensor is not None:
            resistors = {
                Pull.UP: self._pigpio.PUD_UP,
                Pull.DOWN: self._pigpio.PUD_DOWN,
                Pull.NONE: self._pigpio.PUD_OFF,
            }
            pull = resistors[Pull(self._parameters.endstop_pull)]
            self._pi.set_mode(self._sensor, self._pigpio.INPUT)
            self._pi.set_pull_up_down(self._sensor, pull)

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        # A dead daemon appears as a socket error, or as an answer that is too short to unpack.
        except (self._pigpio.error, OSError, struct.error, AttributeError) as error:
            raise PulseProcessError(
                Message(
                    "pigpio failed; check that the daemon pigpiod runs, then home the axis",
                    details=error,
                ),
                fault=CONFIGURATION,
            ) from error


def _level(level: str) -> int:
    return int(level == Level.HIGH.value)
