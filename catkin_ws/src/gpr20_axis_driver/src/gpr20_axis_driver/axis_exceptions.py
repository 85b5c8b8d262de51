"""What can go wrong with an axis."""

from __future__ import annotations

from gpr20_axis_driver import faults
from gpr20_common.errors import Gpr20Error
from gpr20_survey.faults import CONTROL_SILENT, NOT_HOMED


class AxisException(Gpr20Error):
    """An axis refused or failed to do what was asked; `message` is why and what to do."""

    fault = faults.FAILED


class TravelError(AxisException, ValueError):
    """A target lies outside the axis."""

    fault = faults.OUTSIDE_TRAVEL


class NotHomedError(AxisException, RuntimeError):
    """The axis is not homed, so its position is unknown."""

    fault = NOT_HOMED


class AxisBusyError(AxisException, RuntimeError):
    """The axis is still carrying out another motion."""

    fault = faults.BUSY


class AxisOwnedError(AxisException, PermissionError):
    """Another node owns the axis."""

    fault = faults.OWNED


class LeaseLapsedError(AxisException, RuntimeError):
    """The lease of the axis was not renewed in time, or never existed."""

    fault = CONTROL_SILENT


class EndstopError(AxisException, OSError):
    """The endstop did not behave as a working one does."""

    fault = faults.ENDSTOP_STUCK


class MotionStopped(AxisException):
    """The motion was ended on request before it was complete."""

    fault = faults.STOPPED


class PositionLostError(AxisException, RuntimeError):
    """Steps may have been lost, so the position is not trusted any more."""

    fault = faults.POSITION_LOST


class NodeHungError(AxisException, RuntimeError):
    """The motion was ended because the node could not have stopped it."""

    fault = faults.DRIVER_HUNG


class ZeroUnknownError(AxisException, RuntimeError):
    """The zero of an axis without endstop is unknown."""

    fault = faults.ZERO_UNKNOWN


class StepCounterError(AxisException, OSError):
    """The file of an axis's step count cannot be used."""

    fault = faults.STEP_COUNT_NOT_STORED


class PulseProcessError(AxisException, OSError):
    """The pulse process could not be started, or has ended."""

    fault = faults.PULSES_ENDED


class PinLibraryError(AxisException, OSError):
    """The pins of this computer cannot be used."""

    fault = faults.NO_PIN_LIBRARY
