"""The parameters of the height sensor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded
from gpr20_height_sensor.low.adc_interface import CHANNELS

FEWEST_FROZEN = 30
# Buses and chip-select lines beyond this are typing errors.
MAX_SPI_NUMBER = 31
# No sensor of this kind sees as far.
LONGEST_M = 10.0


@dataclass(frozen=True)
class HeightParameters:
    """The sensor, its converter and the estimate.

    A GP2Y0A21YK0F gives distance = scale * (voltage / 1 V) ** -exponent. Sharp's data sheet
    E4-A00201EN gives as typical values 0.4 V at 0.80 m and 1.9 V more at 0.10 m, so 2.3 V there.
    The defaults are the power law through these two points: exponent = ln(0.80 / 0.10) /
    ln(2.3 / 0.4) = 1.188796, scale = 0.80 * 0.4 ** exponent. Individual sensors differ (0.25
    to 0.55 V at 0.80 m): measure two heights with the robot's sensor and set both parameters.

    Attributes:
        spi_bus: Number of the SPI bus.
        spi_device: Chip-select line of the converter.
        spi_speed_hz: Clock of the bus [Hz]; the MCP3008 allows 1.35 MHz at 2.7 V and more
            at higher supplies.
        channel: Channel of the converter.
        reference_voltage_v: Reference of the converter [V]; the robot feeds it with 3.3 V.
        scale_m: Distance at 1 V [m].
        exponent: How steeply the distance falls with the voltage.
        min_distance_m: Shortest valid distance [m]; nearer, the voltage falls again.
        max_distance_m: Longest valid distance [m].
        height_offset_m: Height of the antennas above the sensor [m], negative if they hang
            lower; added to the distance.
        samples: Readings per height.
        update_period_s: Longest time the sensor takes for a new value [s]; 38.3 ms plus or
            minus 9.6 ms according to the data sheet.
        max_spread_m: Largest scaled median absolute deviation of the readings [m]; about two
            steps of the converter at 0.8 m, where one is 5 mm (it is 0.4 mm at 0.2 m).
        frozen_readings: This many readings in a row with the same code mean that the sensor
            is stuck; 0 switches the check off. Noise of one converter step is enough to make
            600 equal readings, a minute of the published ones, impossible.
        publish_rate_hz: Heights published per second [1/s].
    """

    spi_bus: int = bounded(0, MAX_SPI_NUMBER, 0)
    spi_device: int = bounded(0, MAX_SPI_NUMBER, 0)
    # The limits of the MCP3008's data sheet (DS21295).
    spi_speed_hz: int = bounded(10_000, 3_600_000, 1_000_000)
    channel: int = bounded(0, CHANNELS - 1, 0)
    reference_voltage_v: float = bounded(0.25, 5.5, 3.3)
    scale_m: float = bounded(0.001, LONGEST_M, 0.269166)
    exponent: float = bounded(0.1, 10.0, 1.188796)
    min_distance_m: float = bounded(0.001, LONGEST_M, 0.10)
    max_distance_m: float = bounded(0.001, LONGEST_M, 0.80)
    height_offset_m: float = bounded(-2.0, 2.0, 0.0)
    # With fewer than three readings a single bad one decides.
    samples: int = bounded(3, 1000, 5)
    update_period_s: float = bounded(0.0001, 1.0, 0.048)
    max_spread_m: float = bounded(0.0001, 1.0, 0.010)
    frozen_readings: int = bounded(0, 1_000_000, 600)
    publish_rate_hz: float = bounded(0.01, 100.0, 2.0)

    def __post_init__(self) -> None:
        if not self.min_distance_m < self.max_distance_m:
            raise InvalidValueError(
                Message(
                    "{name} is {value:.12g} {unit}; it must be below {upper_name}, which is "
                    "{upper:.12g} {unit}",
                    name="min_distance_m",
                    value=self.min_distance_m,
                    upper_name="max_distance_m",
                    upper=self.max_distance_m,
                    unit="m",
                )
            )
        if 0 < self.frozen_readings < FEWEST_FROZEN:
            raise InvalidValueError(
                Message(
                    "frozen_readings is {readings}; it must be 0 (no check) or at least {least}, "
                    "because a few readings are equal by chance",
                    readings=self.frozen_readings,
                    least=FEWEST_FROZEN,
                ),
                fault=CONFIGURATION,
            )

    def distances_m(self, voltages_v: np.ndarray) -> np.ndarray:
        """Return the distances [m] at voltages [V]; infinity at zero volts."""
        with np.errstate(divide="ignore"):
            return self.scale_m * np.asarray(voltages_v, dtype=np.float64) ** -self.exponent
