"""The MCP3008, an analogue-to-digital converter of 10 bits and eight channels on the SPI bus."""

from __future__ import annotations

import math
import threading
import time
from typing import List, Protocol

from gpr20_common.errors import os_reason
from gpr20_common.faults import NOT_SET_UP
from gpr20_common.message import Message
from gpr20_height_sensor.faults import HeightError

CHANNELS = 8
LARGEST_CODE = 1023
# Data sheet DS21295, section 6.1: a start bit ending the first byte; single-ended mode and
# the channel in the upper half of the second.
START = 0x01
SINGLE_ENDED = 0x08
# The converter drives this bit of the second byte low before the ten bits of the result.
NULL_BIT = 0x04
RESULT_HIGH_BITS = 0x03
CALL_LIMIT_S = 3.0


class SpiBus(Protocol):
    """What the driver uses of an open `spidev.SpiDev`."""

    def xfer2(self, values: List[int]) -> List[int]:
        """Exchange bytes while the chip stays selected; return as many as were sent."""

    def close(self) -> None:
        """Release the bus."""


class AdcInterface:
    """Reads one channel of an MCP3008; usable from several threads at once."""

    def __init__(self, spi: SpiBus, channel: int) -> None:
        self._spi = spi
        self._request = [START, (SINGLE_ENDED | channel) << 4, 0]
        # Held only for one exchange of three bytes, so that no reader waits for another's samples.
        self._lock = threading.Lock()
        self._called_s = math.inf

    @property
    def overdue(self) -> bool:
        """Whether the bus does not return from an exchange, which takes microseconds."""
        return time.monotonic() - self._called_s > CALL_LIMIT_S

    def read_code(self) -> int:
        """Return one conversion made now, 0..1023.

        Raises:
            HeightError: The bus failed, or no converter answered.
        """
        try:
            with self._lock:
                self._called_s = time.monotonic()
                try:
                    # A copy, because spidev changes the list.
                    reply = self._spi.xfer2(list(self._request))
                finally:
                    self._called_s = math.inf
        except OSError as error:
            raise HeightError(
                Message(
                    "the bus of the height sensor's converter failed; check its wiring",
                    details=f"SPI: {error}",
                )
            ) from error
        if reply[1] & NULL_BIT:
            raise HeightError(
                Message(
                    "the height sensor's converter does not answer; check its wiring and supply",
                    details=f"SPI: no MCP3008 answers {reply!r}",
                )
            )
        return (reply[1] & RESULT_HIGH_BITS) << 8 | reply[2]

    def close(self) -> None:
        with self._lock:
            self._spi.close()


def open_spi_bus(bus: int, device: int, speed_hz: int) -> SpiBus:
    """Open the real bus, `/dev/spidev<bus>.<device>`, with a clock [Hz].

    Raises:
        HeightError: The library spidev is missing, or the bus cannot be opened.
    """
    try:
        # Only here, because the library exists and works only on the robot.
        import spidev
    except ImportError as error:
        raise HeightError(
            Message(
                "this computer has no usable SPI bus; on the robot run scripts/setup.sh --robot, "
                "elsewhere launch with robot:=simulated",
                details=error,
            ),
            fault=NOT_SET_UP,
        ) from error
    device_file = f"/dev/spidev{bus}.{device}"
    spi = spidev.SpiDev()
    try:
        spi.open(bus, device)
        spi.max_speed_hz = speed_hz
        spi.mode = 0
    except OSError as error:
        spi.close()
        raise HeightError(
            Message(
                "the SPI bus {device_file} cannot be opened: {reason}; enable SPI on the robot's "
                "computer and allow this user to read and write the file",
                device_file=device_file,
                reason=os_reason(error),
            ),
            fault=NOT_SET_UP,
        ) from error
    return spi
