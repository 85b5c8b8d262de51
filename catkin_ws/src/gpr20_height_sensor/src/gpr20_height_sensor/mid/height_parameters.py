"""The parameters of the height sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.checks import number_between
from gpr20_height_sensor.errors import HeightParameterError
from gpr20_height_sensor.low.adc_interface import CHANNELS
from gpr20_height_sensor.mid.range_curve import RangeCurve

FEWEST_FROZEN = 30
# Buses and chip-select lines beyond this are typing errors.
MAX_SPI_NUMBER = 31


@dataclass(frozen=True)
class HeightParameters:
    """The sensor, its converter and the estimate.

    Attributes:
        spi_bus: Number of the SPI bus.
        spi_device: Chip-select line of the converter.
        spi_speed_hz: Clock of the bus [Hz]; the MCP3008 allows 1.35 MHz at 2.7 V and more
            at higher supplies.
        channel: Channel of the converter.
        reference_voltage_v: Reference of the converter [V]; the robot feeds it with 3.3 V.
        scale_m: See RangeCurve [m].
        exponent: See RangeCurve.
        min_distance_m: Shortest valid distance of the sensor [m].
        max_distance_m: Longest valid distance of the sensor [m].
        height_offset_m: Height of the antennas above the sensor [m], negative if they hang
            lower; added to the distance.
        samples: Readings per height.
        update_period_s: Longest time the sensor takes for a new value [s]; the data sheet
            says 38.3 ms with 9.6 ms more or less.
        max_spread_m: Largest scaled median absolute deviation of the readings [m]; about two
            steps of the converter at 0.8 m, where one is 5 mm (it is 0.4 mm at 0.2 m).
        frozen_readings: So many readings in a row with the very same code are a sensor that
            is stuck; 0: never. Noise of one converter step alone makes 600 equal readings,
            a minute of the published ones, impossible.
        publish_rate_hz: Heights published per second [1/s].
        frame_id: Frame of the sensor in the published message.
        field_of_view_rad: Opening of the sensor's beam in the published message [rad]; for
            display only.
    """

    spi_bus: int = 0
    spi_device: int = 0
    spi_speed_hz: int = 1_000_000
    channel: int = 0
    reference_voltage_v: float = 3.3
    scale_m: float = RangeCurve.scale_m
    exponent: float = RangeCurve.exponent
    min_distance_m: float = RangeCurve.min_distance_m
    max_distance_m: float = RangeCurve.max_distance_m
    height_offset_m: float = 0.0
    samples: int = 5
    update_period_s: float = 0.048
    max_spread_m: float = 0.010
    frozen_readings: int = 600
    publish_rate_hz: float = 2.0
    frame_id: str = "height_sensor"
    field_of_view_rad: float = 0.05

    def __post_init__(self) -> None:
        try:
            number_between("spi_bus", self.spi_bus, 0, MAX_SPI_NUMBER)
            number_between("spi_device", self.spi_device, 0, MAX_SPI_NUMBER)
            number_between("channel", self.channel, 0, CHANNELS - 1)
            # The limits of the MCP3008's data sheet (DS21295).
            number_between("spi_speed_hz", self.spi_speed_hz, 10_000, 3_600_000, "Hz")
            number_between("reference_voltage_v", self.reference_voltage_v, 0.25, 5.5, "V")
            number_between("update_period_s", self.update_period_s, 0.0001, 1.0, "s")
            number_between("max_spread_m", self.max_spread_m, 0.0001, 1.0, "m")
            number_between("field_of_view_rad", self.field_of_view_rad, 0.0, math.pi, "rad")
            number_between("publish_rate_hz", self.publish_rate_hz, 0.01, 100.0, "1/s")
            # With fewer than three readings a single bad one decides.
            number_between("samples", self.samples, 3, 1000)
            number_between("frozen_readings", self.frozen_readings, 0, 1_000_000)
            if 0 < self.frozen_readings < FEWEST_FROZEN:
                raise InvalidValueError(
                    f"frozen_readings is {self.frozen_readings}; it must be 0 for no check, or at "
                    f"least {FEWEST_FROZEN}, because a few readings are equal by chance"
                )
            number_between("height_offset_m", self.height_offset_m, -2.0, 2.0, "m")
        except InvalidValueError as error:
            raise HeightParameterError(str(error)) from error
        # A curve that makes no sense stops the node at its start.
        _ = self.curve

    @property
    def curve(self) -> RangeCurve:
        """From voltage to distance."""
        return RangeCurve(self.scale_m, self.exponent, self.min_distance_m, self.max_distance_m)
