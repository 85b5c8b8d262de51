"""The 40 pins of the header of a Raspberry Pi 4, and what uses them beside this software.

From the pinout of the Raspberry Pi documentation (raspberrypi.com, "GPIO and the 40-pin header"),
the alternative functions in the data sheet "BCM2711 ARM Peripherals", section 5.3, and the chip
selects that the overlays spi0 to spi6 of the Raspberry Pi's kernel use by default.
"""

from __future__ import annotations

from typing import Dict, Mapping, Tuple

# Pins of the header [BOARD] that carry no signal.
NOT_GPIO: Mapping[int, str] = {
    **dict.fromkeys((1, 17), "3.3 V"),
    **dict.fromkeys((2, 4), "5 V"),
    **dict.fromkeys((6, 9, 14, 20, 25, 30, 34, 39), "ground"),
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
# GPIO numbers of MISO, MOSI and SCLK, and of the chip selects. Bus 2 is not on the header.
SPI_BUSES: Mapping[int, Tuple[Tuple[int, int, int], Tuple[int, ...]]] = {
    0: ((9, 10, 11), (8, 7)),
    1: ((19, 20, 21), (18, 17, 16)),
    3: ((1, 2, 3), (0, 24)),
    4: ((5, 6, 7), (4, 25)),
    5: ((13, 14, 15), (12, 26)),
    6: ((19, 20, 21), (18, 27)),
}
RESERVED: Mapping[int, str] = {
    **dict.fromkeys(
        EEPROM, "at every start the Raspberry Pi sends pulses to this pin, looking for an EEPROM"
    ),
    **dict.fromkeys(
        (8, 10), "this is the serial port, whose console Linux prints on unless it is off"
    ),
    **dict.fromkeys(I2C, "this is I2C, with a resistor of 1.8 kOhm to 3.3 V"),
    26: "this is CE1 of SPI0, which Linux drives unless only one chip select is set up",
}


def spi_pins(bus: int, device: int) -> Dict[str, int]:
    """Return name and pin [BOARD] of each line that a device of a bus uses."""
    lines, selects = SPI_BUSES[bus]
    named = {**dict(zip(("MISO", "MOSI", "SCLK"), lines)), f"CE{device}": selects[device]}
    return {name: BOARD_OF_GPIO[gpio] for name, gpio in named.items()}


# For anything: what neither the Raspberry Pi nor the usual converter uses.
FREE = sorted({*GPIO_OF_BOARD} - {*RESERVED} - {*spi_pins(0, 0).values()})
