"""The SPI bus of the robot's computer."""

from __future__ import annotations

from typing import List, Protocol

from gpr20_height_sensor.errors import SpiError


class SpiBus(Protocol):
    """What the driver uses of an open `spidev.SpiDev`."""

    def xfer2(self, values: List[int]) -> List[int]:
        """Exchange bytes while the chip stays selected; return as many as were sent."""

    def close(self) -> None:
        """Give the bus back."""


def open_spi_bus(bus: int, device: int, speed_hz: int) -> SpiBus:
    """Open the real bus, `/dev/spidev<bus>.<device>`.

    Args:
        bus: Number of the bus.
        device: Number of its chip-select line.
        speed_hz: Clock [Hz].

    Raises:
        SpiError: The library spidev is missing, or the bus cannot be opened.
    """
    try:
        # Only here, because the library exists and works on the robot alone.
        import spidev
    except ImportError as error:
        raise SpiError(
            f"the SPI bus cannot be used: {error}; on the robot run scripts/setup.sh --robot, "
            "elsewhere launch with robot:=simulated"
        ) from error
    device_file = f"/dev/spidev{bus}.{device}"
    spi = spidev.SpiDev()
    try:
        spi.open(bus, device)
        spi.max_speed_hz = speed_hz
        spi.mode = 0
    except OSError as error:
        spi.close()
        raise SpiError(
            f"{device_file} cannot be opened: {error}; enable SPI on the robot's computer and "
            "let this user read and write the file"
        ) from error
    return spi
