"""The faults of the height sensor."""

from __future__ import annotations

from gpr20_common.message import Fault, Message

FROZEN = Fault(
    "height.frozen",
    Message(
        "Press STOP. Hold a board below the height sensor, without touching the ground. If its "
        "value changes, let the person who maintains the robot raise frozen_readings; if not, "
        "replace the sensor."
    ),
)
