"""What can go wrong with the height sensor."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import PART_SILENT
from gpr20_survey.faults import SENSOR_FAILED


class HeightError(Gpr20Error):
    """The height could not be measured."""

    fault = SENSOR_FAILED


class HeightStoppedError(HeightError):
    """The measurement was ended because the node is shutting down."""

    fault = PART_SILENT
