"""What can go wrong with the height sensor."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import PART_SILENT
from gpr20_common.message import Fault, Message
from gpr20_survey.faults import SENSOR_FAILED

FROZEN = Fault(
    "height.frozen",
    Message(
        "Press STOP. Hold a board below the height sensor, without touching the ground. If its "
        "value changes, let the person who maintains the robot raise frozen_readings; if not, "
        "replace the sensor."
    ),
)


class HeightError(Gpr20Error):
    """The height could not be measured."""

    fault = SENSOR_FAILED


class HeightStoppedError(HeightError):
    """The measurement was ended because the node is shutting down."""

    fault = PART_SILENT
