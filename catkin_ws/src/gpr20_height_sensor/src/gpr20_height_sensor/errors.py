"""What can go wrong with the height sensor."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_height_sensor import faults


class HeightError(Gpr20Error):
    """The height could not be measured."""

    fault = faults.SENSOR_OFF


class SpiError(HeightError, OSError):
    """The SPI bus cannot be used, or the converter on it does not answer properly."""

    fault = faults.CONVERTER_FAILED


class SensorStuckError(HeightError):
    """The converter reads one end of its scale, or the same code all the time.

    The sensor is off, unplugged or broken.
    """

    fault = faults.SENSOR_OFF


class SensorRangeError(HeightError, ValueError):
    """The ground is nearer or farther than the sensor can measure."""

    fault = faults.OUT_OF_RANGE


class SensorNoiseError(HeightError):
    """The readings scatter too much."""

    fault = faults.NOISY


class HeightStoppedError(HeightError):
    """The measurement was ended because the node is shutting down."""

    fault = faults.SHUTTING_DOWN
