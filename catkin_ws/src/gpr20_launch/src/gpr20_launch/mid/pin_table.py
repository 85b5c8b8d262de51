"""The 40 pins of the header of a Raspberry Pi 4, and what uses them beside this software.

From the pinout of the Raspberry Pi documentation (raspberrypi.com, "GPIO and the 40-pin header"),
the alternative functions in the data sheet "BCM2711 ARM Peripherals", section 5.3, and the chip
selects that the overlays spi0 to spi6 of the Raspberry Pi's kernel use by default.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Mapping, Tuple

from gpr20_common.message import Message

_V3, _V5, _GROUND = Message("3.3 V"), Message("5 V"), Message("ground")
# Pins of the header [BOARD] that carry no signal.
NOT_GPIO: Mapping[int, Message] = {
    **dict.fromkeys((1, 17), _V3),
    **dict.fromkeys((2, 4), _V5),
    **dict.fromkeys((6, 9, 14, 20, 25, 30, 34, 39), _GROUND),
}
GPIO_OF_BOARD: Mapping[int, int] = {
    **{3: 2, 5: 3, 7: 4, 8: 14, 10: 15, 11: 17, 12: 18, 13: 27, 15: 22, 16: 23, 18: 24, 19: 10},
    **{21: 9, 22: 25, 23: 11, 24: 8, 26: 7, 27: 0, 28: 1, 29: 5, 31: 6, 32: 12, 33: 13, 35: 19},
    **{36: 16, 37: 26, 38: 20, 40: 21},
}
BOARD_OF_GPIO: Mapping[int, int] = {gpio: board for board, gpio in GPIO_OF_BOARD.items()}

# At every start the firmware looks for an EEPROM here, with pulses of its own.
EEPROM = (27, 28)
I2C = (3, 5)
# The console of Linux and of the boot loader prints on the first one unless it is switched off.
UART = (8, 10)


@dataclass(frozen=True)
class SpiBus:
    """The lines of an SPI bus [GPIO numbers].

    Attributes:
        miso: Data to the computer.
        mosi: Data from the computer.
        clock: Clock.
        selects: Chip selects, the first one of device 0.
    """

    miso: int
    mosi: int
    clock: int
    selects: Tuple[int, ...]

    def pins(self, device: int) -> Dict[str, int]:
        """Return name and pin [BOARD] of each line that a device uses."""
        lines = {"MISO": self.miso, "MOSI": self.mosi, "SCLK": self.clock}
        lines[f"CE{device}"] = self.selects[device]
        return {name: BOARD_OF_GPIO[gpio] for name, gpio in lines.items()}


# Bus 2 has no lines on the header.
SPI_BUSES: Mapping[int, SpiBus] = {
    0: SpiBus(9, 10, 11, (8, 7)),
    1: SpiBus(19, 20, 21, (18, 17, 16)),
    3: SpiBus(1, 2, 3, (0, 24)),
    4: SpiBus(5, 6, 7, (4, 25)),
    5: SpiBus(13, 14, 15, (12, 26)),
    6: SpiBus(19, 20, 21, (18, 27)),
}
