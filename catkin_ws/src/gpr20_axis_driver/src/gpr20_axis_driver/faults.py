"""The faults of an axis; those by which other packages decide are in `gpr20_survey.faults`."""

from __future__ import annotations

from gpr20_common.message import Fault, Message

PULSE_LATE = Fault(
    "axis.pulse_late",
    Message(
        "End other programs on the robot's computer, and check that it is not hot. Then home the "
        "axis."
    ),
)
FAILED = Fault(
    "axis.failed",
    Message("Home the axis. If it happens again, switch the robot off and on and keep the log."),
)
