"""An SPI bus with an MCP3008 on it, as an object with the calls of `spidev.SpiDev`."""

from __future__ import annotations

from typing import Callable, List

BITS_PER_BYTE = 8
# After the start bit come the mode and three channel bits, then a bit time for sampling.
CONFIGURATION_BITS = 4
SAMPLING_BITS = 1
RESULT_BITS = 10


class SimulatedSpi:
    """Answers bit by bit as the converter does, wherever the start bit is."""

    def __init__(self, convert: Callable[[int], int]) -> None:
        """Put a converter on the bus.

        Args:
            convert: Takes a channel and returns its code now, 0..1023.
        """
        self._convert = convert
        self.max_speed_hz = 0
        self.mode = 0
        self._is_open = True

    def xfer2(self, values: List[int]) -> List[int]:
        """Exchange bytes while the chip stays selected.

        Raises:
            OSError: The bus was closed.
        """
        if not self._is_open:
            raise OSError("the SPI bus is closed")
        sent = [value >> shift & 1 for value in values for shift in range(BITS_PER_BYTE)[::-1]]
        # The output floats until the converter drives it; a pull-up makes that ones.
        received = [1] * len(sent)
        if 1 in sent:
            self._answer(sent, received, sent.index(1))
        return [
            int("".join(map(str, received[i : i + BITS_PER_BYTE])), 2)
            for i in range(0, len(received), BITS_PER_BYTE)
        ]

    def close(self) -> None:
        """Close the bus."""
        self._is_open = False

    def _answer(self, sent: List[int], received: List[int], start: int) -> None:
        configuration = sent[start + 1 : start + 1 + CONFIGURATION_BITS]
        if len(configuration) < CONFIGURATION_BITS:
            return
        single_ended, *channel_bits = configuration
        channel = int("".join(map(str, channel_bits)), 2)
        # Between two inputs of a differential pair there is nothing on this robot.
        code = self._convert(channel) if single_ended else 0
        # The null bit and the result, then zeros for as long as the clock runs.
        null_bit = start + 1 + CONFIGURATION_BITS + SAMPLING_BITS
        result = [code >> shift & 1 for shift in range(RESULT_BITS)[::-1]]
        for i, bit in enumerate([0] + result + [0] * len(sent)):
            if null_bit + i < len(received):
                received[null_bit + i] = bit
