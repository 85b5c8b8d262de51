"""One filtered height from several readings of the sensor."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Callable, List

import numpy as np

from gpr20_common.low.clock import Clock, time_of_day_us
from gpr20_common.message import Message, numeral
from gpr20_height_sensor import faults
from gpr20_height_sensor.errors import HeightError, HeightStoppedError
from gpr20_height_sensor.low.adc_interface import LARGEST_CODE, AdcInterface
from gpr20_height_sensor.mid.height_parameters import HeightParameters
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

    Several measurements may run at the same time; none waits for another.
    """

    def __init__(
        self,
        adc: AdcInterface,
        parameters: HeightParameters,
        clock: Clock,
        now_us: Callable[[], int] = time_of_day_us,
    ) -> None:
        """Make a driver of the sensor behind a converter.

        Args:
            adc: The converter.
            parameters: The sensor and the estimate.
            clock: Spaces the readings.
            now_us: Returns the time [microseconds since 1970, UTC].
        """
        self._adc = adc
        self._parameters = parameters
        self._clock = clock
        self._now_us = now_us
        self._lock = threading.Lock()
        self._last_code = -1
        self._equal_readings = 0
        self._stop = threading.Event()

    @property
    def parameters(self) -> HeightParameters:
        """The sensor and the estimate."""
        return self._parameters

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
        """Return one height from readings that the sensor made after this call.

        Raises:
            HeightError: The sensor is stuck, out of its range, too noisy, or does not answer.
        """
        return self.height_from(self.take_readings())

    def take_readings(self) -> HeightReadings:
        """Return readings that the sensor made after this call.

        Raises:
            HeightError: The converter does not answer.
        """
        codes = np.array(self._fresh_samples(), dtype=np.float64)
        # The converter's result is code / 1024 of its reference (data sheet, equation 4-2).
        voltages_v = codes * (self._parameters.reference_voltage_v / (LARGEST_CODE + 1))
        return HeightReadings(codes, voltages_v, self._now_us())

    def height_from(self, readings: HeightReadings) -> HeightMeasurement:
        """Return the height that the last readings mean.

        Raises:
            HeightError: The sensor is stuck, out of its range, or too noisy.
        """
        self._check_not_stuck(readings.codes)
        distances_m = self._parameters.distances_m(readings.voltages_v)
        distance_m = float(np.median(distances_m))
        self._check_in_range(distance_m)
        self._check_not_frozen()
        spread_m = NORMAL_MAD_SCALE * float(np.median(np.abs(distances_m - distance_m)))
        self._check_quiet(spread_m, distances_m)
        height_m = distance_m + self._parameters.height_offset_m
        return HeightMeasurement(height_m, spread_m, readings.measured_us)

    def shut_down(self) -> None:
        """End all measurements, refuse new ones, and release the bus."""
        self._stop.set()
        self._adc.close()

    def _fresh_samples(self) -> List[int]:
        period_s = self._parameters.update_period_s
        next_s = self._clock.now_s() + PERIODS_UNTIL_FRESH * period_s
        codes = []
        for _ in range(self._parameters.samples):
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
        nearest_m, farthest_m = self._parameters.min_distance_m, self._parameters.max_distance_m
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
        limit, count = self._parameters.frozen_readings, self._equal_readings
        if 0 < limit <= count:
            raise HeightError(
                Message(
                    "the height sensor is stuck: its last {readings} readings are identical; test: "
                    "hold a board below the sensor; if the value changes, raise frozen_readings (0 "
                    "switches this check off); if not, replace the sensor",
                    readings=count,
                ),
                fault=faults.FROZEN,
            )

    def _check_quiet(self, spread_m: float, distances_m: np.ndarray) -> None:
        limit_m = self._parameters.max_spread_m
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
