"""The infrared height sensor, its converter and the SPI bus: from the true height to bytes."""

from __future__ import annotations

import math
import threading
from typing import Callable, List

import numpy as np

from gpr20_simulator.low.shared_state import AdcFault
from gpr20_simulator.mid.world.scene import Adc

SENSOR_CHANNEL = 0
LARGEST_CODE = 1023
# Typical values of the data sheet of the GP2Y0A21YK0F: 0.4 V at 0.80 m, and 1.9 V more at 0.10 m.
FAR_M, FAR_V = 0.80, 0.4
NEAR_M, NEAR_V = 0.10, 0.4 + 1.9
# Nearer than where the curve reaches this voltage, the output falls again.
PEAK_V = 3.1
STEEPNESS = math.log(NEAR_V / FAR_V) / math.log(FAR_M / NEAR_M)
OUT_OF_RANGE_M = 1.6


def sensor_voltage_v(distance_m: float) -> float:
    """Return the typical output of a GP2Y0A21YK0F [V] at a distance [m]."""
    peak_m = FAR_M * (PEAK_V / FAR_V) ** (-1.0 / STEEPNESS)
    if distance_m <= peak_m:
        return PEAK_V * max(0.0, distance_m) / peak_m
    return FAR_V * (distance_m / FAR_M) ** -STEEPNESS


class RangeSensor:
    """What the converter reads on each of its channels.

    The real sensor holds each value for about 38 ms; here it follows at once.
    """

    def __init__(
        self, adc: Adc, true_height_m: Callable[[], float], fault: Callable[[], AdcFault]
    ) -> None:
        """Put a sensor on channel 0; the others are grounded.

        Args:
            adc: Converter and noise.
            true_height_m: Gives the antenna height where the carriage is now [m].
            fault: Gives what is wrong with the converter now.
        """
        self._adc = adc
        self._true_height_m = true_height_m
        self._fault = fault
        self._random = np.random.default_rng(adc.seed)
        # The generator is not safe to share between threads.
        self._lock = threading.Lock()

    def code(self, channel: int) -> int:
        """Return the code of a channel now, 0..1023."""
        fault = self._fault()
        if fault is AdcFault.STUCK:
            return LARGEST_CODE
        if channel != SENSOR_CHANNEL:
            return 0
        out_of_range = fault is AdcFault.OUT_OF_RANGE
        distance_m = OUT_OF_RANGE_M if out_of_range else self._true_height_m()
        with self._lock:
            noise_v = float(self._random.normal(0.0, self._adc.noise_v))
        voltage_v = sensor_voltage_v(distance_m) + noise_v
        code = round(voltage_v / self._adc.reference_voltage_v * (LARGEST_CODE + 1))
        return min(max(code, 0), LARGEST_CODE)


class SimulatedSpi:
    """An SPI bus with an MCP3008 on it, as an object with the calls of `spidev.SpiDev`.

    It answers bit by bit as the converter does, wherever the start bit is.
    """

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
        sent = int.from_bytes(bytes(values), "big")
        # The output floats until the converter drives it; a pull-up makes that ones.
        received = (1 << 8 * len(values)) - 1
        start = sent.bit_length() - 1
        # After the start bit come the mode, three channel bits and a bit time for sampling; then
        # the converter sends a zero and its code, and zeros for as long as the clock runs.
        sampled = start - 5
        if sampled > 0:
            is_single_ended, channel = sent >> start - 1 & 1, sent >> start - 4 & 0b111
            # Between two inputs of a differential pair there is nothing on this robot.
            code = self._convert(channel) if is_single_ended else 0
            received -= (1 << sampled) - 1
            received |= code << sampled >> 11
        return list(received.to_bytes(len(values), "big"))

    def close(self) -> None:
        """Close the bus."""
        self._is_open = False
