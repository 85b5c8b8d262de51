"""What is refused of an axis's parameters and targets."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error, InvalidValueError


class AxisException(Gpr20Error):
    """An axis refused or failed to do what was asked."""


class AxisParameterError(AxisException, InvalidValueError):
    """A parameter of the axis is not allowed."""


class TravelError(AxisException, ValueError):
    """A target lies outside the axis."""
