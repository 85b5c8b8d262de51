"""What can go wrong with an axis."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error


class AxisException(Gpr20Error):
    """An axis refused or failed to do what was asked; `message` is why and what to do."""


class TravelError(AxisException, ValueError):
    """A target lies outside the axis."""


class NotHomedError(AxisException, RuntimeError):
    """The axis is not homed, so its position is unknown."""


class AxisBusyError(AxisException, RuntimeError):
    """The axis is still carrying out another motion."""


class EndstopError(AxisException, OSError):
    """The endstop did not behave as a working one does."""


class MotionStopped(AxisException):
    """The motion was ended on request before it was complete."""


class PositionLostError(AxisException, RuntimeError):
    """Steps may have been lost, so the position is not trusted any more."""


class NodeHungError(AxisException, RuntimeError):
    """The motion was ended because the node could not have stopped it."""


class ZeroUnknownError(AxisException, RuntimeError):
    """The zero of an axis without endstop is unknown."""


class StepCounterError(AxisException, OSError):
    """The file of an axis's step count cannot be used."""


class PulseProcessError(AxisException, OSError):
    """The pulse process could not be started, or has ended."""


class PinLibraryError(AxisException, OSError):
    """The pins of this computer cannot be used."""
