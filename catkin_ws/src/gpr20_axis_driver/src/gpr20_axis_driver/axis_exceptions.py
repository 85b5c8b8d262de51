"""What can go wrong with an axis."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error


class AxisException(Gpr20Error):
    """An axis refused or failed to do what was asked; `message` says why and what to do."""


class TravelError(AxisException, ValueError):
    """A target lies outside the axis."""


class NotHomedError(AxisException, RuntimeError):
    """The axis does not know where it is, so it has no legal range."""


class AxisBusyError(AxisException, RuntimeError):
    """The axis is still carrying out something else."""


class EndstopError(AxisException, OSError):
    """The endstop did not behave as a working one does."""


class MotionStopped(AxisException):
    """The motion was ended on request before it was complete."""


class PositionLostError(AxisException, RuntimeError):
    """Steps may have been lost, so the position is not trusted any more."""


class NodeHungError(AxisException, RuntimeError):
    """The motion was ended because nobody could have stopped it."""


class ZeroUnknownError(AxisException, RuntimeError):
    """An axis without endstop does not remember where its zero is."""


class StepCounterError(AxisException, OSError):
    """The file that holds an axis's step count cannot be used."""


class PulseProcessError(AxisException, OSError):
    """The process that makes the pulses could not be started, or has ended."""


class PinLibraryError(AxisException, OSError):
    """The pins of this computer cannot be used."""
