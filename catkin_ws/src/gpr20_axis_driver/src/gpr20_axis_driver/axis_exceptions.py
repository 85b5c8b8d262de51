"""What can go wrong with an axis."""

from __future__ import annotations

from gpr20_axis_driver import faults
from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import (
    ASKED_FOR,
    CONFIGURATION,
    IN_USE,
    NOT_ALLOWED,
    NOT_SET_UP,
    OVERLOADED,
)
from gpr20_survey.faults import CONTROL_SILENT, ENDSTOP, NOT_HOMED, ZERO_UNKNOWN


class AxisException(Gpr20Error):
    """An axis refused or failed to do what was asked; `message` is why and what to do."""

    fault = faults.FAILED


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


class NodeHungError(AxisException, RuntimeError):
    """The motion was ended because the node could not have stopped it."""

    fault = OVERLOADED


class ZeroUnknownError(AxisException, RuntimeError):
    """The zero of an axis without endstop is unknown."""

    fault = ZERO_UNKNOWN


class StepCounterError(AxisException, OSError):
    """The file of an axis's step count cannot be used."""

    fault = CONFIGURATION


class PulseProcessError(AxisException, OSError):
    """The pulse process could not be started, or has ended."""

    fault = faults.FAILED


class PinLibraryError(AxisException, OSError):
    """The pins of this computer cannot be used."""

    fault = NOT_SET_UP
