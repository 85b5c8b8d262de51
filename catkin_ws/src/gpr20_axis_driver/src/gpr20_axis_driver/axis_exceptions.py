"""What can go wrong with an axis."""

from __future__ import annotations

from gpr20_survey.axes.errors import AxisException, AxisParameterError, TravelError

__all__ = [
    "AxisBusyError",
    "AxisException",
    "AxisParameterError",
    "EndstopError",
    "MotionStopped",
    "NodeHungError",
    "NotHomedError",
    "PositionLostError",
    "PulseProcessError",
    "StepMemoryError",
    "TravelError",
    "ZeroUnknownError",
]


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


class StepMemoryError(AxisException, OSError):
    """The file that holds an axis's step count cannot be used."""


class PulseProcessError(AxisException, OSError):
    """The process that makes the pulses could not be started, or has ended."""
