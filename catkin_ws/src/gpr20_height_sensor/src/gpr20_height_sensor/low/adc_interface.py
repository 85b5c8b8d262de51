"""The MCP3008, an analogue-to-digital converter of 10 bits and eight channels."""

from __future__ import annotations

import threading

from gpr20_height_sensor.errors import HeightParameterError, SpiError
from gpr20_height_sensor.low.spi_bus import SpiBus

CHANNELS = 8
LARGEST_CODE = 1023
# Data sheet DS21295, section 6.1: a start bit ending the first byte; single-ended mode and
# the channel in the upper half of the second.
START = 0x01
SINGLE_ENDED = 0x08
# The converter drives this bit of the second byte low before the ten bits of the result.
NULL_BIT = 0x04
RESULT_HIGH_BITS = 0x03


class AdcInterface:
    """Reads one channel of an MCP3008; usable from several threads at once."""

    def __init__(self, spi: SpiBus, channel: int) -> None:
        """Use a channel of the converter on a bus.

        Raises:
            HeightParameterError: There is no such channel.
        """
        if not 0 <= channel < CHANNELS:
            raise HeightParameterError(
                f"channel of the converter is {channel}; it must lie between 0 and {CHANNELS - 1}"
            )
        self._spi = spi
        self._request = [START, (SINGLE_ENDED | channel) << 4, 0]
        # Held for one exchange of three bytes only, so that no reader waits for another's samples.
        self._lock = threading.Lock()

    def read_code(self) -> int:
        """Return one conversion made now, 0..1023.

        Raises:
            SpiError: The bus failed, or what answered is not a converter.
        """
        try:
            with self._lock:
                # A copy, because spidev writes into the list it is given.
                reply = self._spi.xfer2(list(self._request))
        except OSError as error:
            raise SpiError(f"the SPI bus failed: {error}; check the wiring") from error
        if len(reply) != len(self._request) or any(not 0 <= byte <= 0xFF for byte in reply):
            raise SpiError(f"the SPI bus gave {reply!r}; three bytes were expected")
        if reply[1] & NULL_BIT:
            raise SpiError(
                f"no MCP3008 answers on the SPI bus (it gave {reply!r}); check wiring and supply"
            )
        return (reply[1] & RESULT_HIGH_BITS) << 8 | reply[2]

    def close(self) -> None:
        """Give the bus back."""
        with self._lock:
            self._spi.close()
