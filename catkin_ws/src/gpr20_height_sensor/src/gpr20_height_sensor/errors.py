"""What can go wrong with the height sensor."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import PART_SILENT
from gpr20_survey.faults import NO_GROUND, SENSOR_FAILED


class HeightError(Gpr20Error):
    """The height could not be measured."""

    fault = SENSOR_FAILED


class SpiError(HeightError, OSError):
    """The SPI bus cannot be used, or the converter on it does not answer properly."""

    fault = SENSOR_FAILED


class SensorStuckError(HeightError):
    """The converter reads one end of its scale, or the same code all the time.

    The sensor is off, unplugged or broken.
    """

    fault = SENSOR_FAILED


class SensorRangeError(HeightError, ValueError):
    """The ground is nearer or farther than the sensor can measure."""

    fault = NO_GROUND


class SensorNoiseError(HeightError):
    """The readings scatter too much."""

    fault = SENSOR_FAILED


class HeightStoppedError(HeightError):
    """The measurement was ended because the node is shutting down."""

    fault = PART_SILENT
