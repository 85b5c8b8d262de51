"""One filtered height from several readings of the sensor, and the parameters of both."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Callable, List

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.message import Message, numeral
from gpr20_common.mid.codec import bounded
from gpr20_height_sensor.adc_interface import CHANNELS, LARGEST_CODE, AdcInterface
from gpr20_height_sensor.faults import FROZEN, HeightError, HeightStoppedError
from gpr20_survey.faults import NO_GROUND

# Makes the median absolute deviation of normally distributed readings their standard deviation.
NORMAL_MAD_SCALE = 1.4826
# The sensor's present value was measured in the period before the last one at the earliest.
PERIODS_UNTIL_FRESH = 2
# What a reading at one end of the converter's scale means.
RAILS = {
    0: Message("the sensor is off or unplugged"),
    LARGEST_CODE: Message("short circuit"),
}
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


@dataclass(frozen=True)
class HeightMeasurement:
    """A height and its uncertainty.

    Attributes:
        height_m: Antenna above ground [m].
        spread_m: Scaled median absolute deviation of the readings [m].
        measured_us: When the last reading was taken [microseconds since 1970, UTC].
    """

    height_m: float
    spread_m: float
    measured_us: int


@dataclass(frozen=True)
class HeightReadings:
    """Readings of the sensor, before anything is concluded from them.

    Attributes:
        codes: Of the converter, 0..1023.
        voltages_v: At its input [V].
        measured_us: When the last one was taken [microseconds since 1970, UTC].
    """

    codes: np.ndarray
    voltages_v: np.ndarray
    measured_us: int

    @property
    def voltage_v(self) -> float:
        """Median of the voltages [V]."""
        return float(np.median(self.voltages_v))


class HeightDriver:
    """Computes a robust height from fresh readings, or raises an error with the reason.

    Several measurements may run at the same time; none waits for another. The clock spaces their
    readings; `now_us` returns the time [microseconds since 1970, UTC].
    """

    def __init__(
        self,
        adc: AdcInterface,
        parameters: HeightParameters,
        clock: Clock,
        now_us: Callable[[], int] = time_of_day_us,
    ) -> None:
        self._adc = adc
        self.parameters = parameters
        self._clock = clock
        self._now_us = now_us
        self._lock = threading.Lock()
        self._last_code = -1
        self._equal_readings = 0
        self._stop = threading.Event()

    def take_sample(self) -> int:
        """Return one reading of the converter made now, 0..1023.

        Raises:
            HeightError: The converter does not answer.
        """
        code = self._adc.read_code()
        with self._lock:
            self._equal_readings = self._equal_readings + 1 if code == self._last_code else 1
            self._last_code = code
        return code

    def take_measurement(self) -> HeightMeasurement:
        """Return one height from readings that the sensor made after this call."""
        return self.height_from(self.take_readings())

    def take_readings(self) -> HeightReadings:
        """Return readings that the sensor made after this call.

        Raises:
            HeightError: The converter does not answer.
        """
        codes = np.array(self._fresh_samples(), dtype=np.float64)
        # The converter's result is code / 1024 of its reference (data sheet, equation 4-2).
        voltages_v = codes * (self.parameters.reference_voltage_v / (LARGEST_CODE + 1))
        return HeightReadings(codes, voltages_v, self._now_us())

    def height_from(self, readings: HeightReadings) -> HeightMeasurement:
        """Return the height that the last readings mean.

        Raises:
            HeightError: The sensor is stuck, out of its range, or too noisy.
        """
        self._check_not_stuck(readings.codes)
        distances_m = self.parameters.distances_m(readings.voltages_v)
        distance_m = float(np.median(distances_m))
        self._check_in_range(distance_m)
        self._check_not_frozen()
        spread_m = NORMAL_MAD_SCALE * float(np.median(np.abs(distances_m - distance_m)))
        self._check_quiet(spread_m, distances_m)
        height_m = distance_m + self.parameters.height_offset_m
        return HeightMeasurement(height_m, spread_m, readings.measured_us)

    def shut_down(self) -> None:
        """End all measurements, refuse new ones, and release the bus."""
        self._stop.set()
        self._adc.close()

    def _fresh_samples(self) -> List[int]:
        period_s = self.parameters.update_period_s
        next_s = self._clock.now_s() + PERIODS_UNTIL_FRESH * period_s
        codes = []
        for _ in range(self.parameters.samples):
            if self._clock.wait_s(self._stop, max(0.0, next_s - self._clock.now_s())):
                raise HeightStoppedError(Message("the height sensor is shutting down"))
            codes.append(self.take_sample())
            # From now, not from the schedule: after a late reading, the next one must not fall
            # into the same period of the sensor.
            next_s = self._clock.now_s() + period_s
        return codes

    def _check_not_stuck(self, codes: np.ndarray) -> None:
        for rail, cause in RAILS.items():
            at_rail = int(np.count_nonzero(codes == rail))
            if 2 * at_rail >= len(codes):
                raise HeightError(
                    Message(
                        "the height sensor is stuck: {stuck} of {readings} readings are {rail}, "
                        "the end of the converter's scale ({cause}); check its plug and supply",
                        stuck=at_rail,
                        readings=len(codes),
                        rail=rail,
                        cause=cause,
                    )
                )

    def _check_in_range(self, distance_m: float) -> None:
        nearest_m, farthest_m = self.parameters.min_distance_m, self.parameters.max_distance_m
        if not nearest_m <= distance_m <= farthest_m:
            raise HeightError(
                Message(
                    "the height sensor reads {distance} m; it measures from {nearest_m:g} to "
                    "{farthest_m:g} m; check the height of the antennas and that the sensor sees "
                    "the ground",
                    # It can be infinite, which JSON does not know.
                    distance=numeral(distance_m, ".3f"),
                    nearest_m=nearest_m,
                    farthest_m=farthest_m,
                ),
                fault=NO_GROUND,
            )

    def _check_not_frozen(self) -> None:
        # One measurement cannot distinguish a dead sensor from a still one; the noise of many can.
        limit, count = self.parameters.frozen_readings, self._equal_readings
        if 0 < limit <= count:
            raise HeightError(
                Message(
                    "the height sensor is stuck: its last {readings} readings are identical; test: "
                    "hold a board below the sensor; if the value changes, raise frozen_readings (0 "
                    "switches this check off); if not, replace the sensor",
                    readings=count,
                ),
                fault=FROZEN,
            )

    def _check_quiet(self, spread_m: float, distances_m: np.ndarray) -> None:
        limit_m = self.parameters.max_spread_m
        if spread_m > limit_m:
            raise HeightError(
                Message(
                    "the height readings scatter by {spread} m (from {lowest} to {highest} m); at "
                    "most {limit_m:g} m is allowed; check the sensor's supply and that the "
                    "antennas do not move",
                    spread=numeral(spread_m, ".4f"),
                    lowest=numeral(distances_m.min(), ".3f"),
                    highest=numeral(distances_m.max(), ".3f"),
                    limit_m=limit_m,
                )
            )
