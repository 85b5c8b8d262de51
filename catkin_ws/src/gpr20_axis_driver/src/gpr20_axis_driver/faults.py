"""What can go wrong with an axis; faults by which others decide are in `gpr20_survey.faults`."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import ASKED_FOR, IN_USE, NOT_ALLOWED
from gpr20_common.message import Fault, Message
from gpr20_survey.faults import AXIS_MAY_MOVE, CONTROL_SILENT, ENDSTOP, NOT_HOMED

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


class AxisException(Gpr20Error):
    """An axis refused or failed to do what was asked; `message` is why and what to do."""

    fault = FAILED


class TravelError(AxisException, ValueError):
    """A target lies outside the axis."""

    fault = NOT_ALLOWED


class NotHomedError(AxisException, RuntimeError):
    """The axis is not homed, or steps may have been lost: its position is unknown."""

    fault = NOT_HOMED


class AxisBusyError(AxisException, RuntimeError):
    """The axis is still carrying out another motion, or another node owns it."""

    fault = IN_USE


class LeaseLapsedError(AxisException, RuntimeError):
    """The lease of the axis was not renewed in time, or never existed."""

    fault = CONTROL_SILENT


class EndstopError(AxisException, OSError):
    """The endstop did not behave as a working one does."""

    fault = ENDSTOP


class MotionStopped(AxisException):
    """The motion was ended on request before it was complete."""

    fault = ASKED_FOR


class PulseProcessError(AxisException, OSError):
    """The pulse process could not be started, or has ended."""


class ControllerError(AxisException, OSError):
    """The controller does not answer, or reports a fault: the position is no longer known."""

    fault = AXIS_MAY_MOVE
