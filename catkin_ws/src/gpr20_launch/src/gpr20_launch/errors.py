"""Errors of a launch."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED


class ConfigurationError(Gpr20Error, ValueError):
    """A file of the robot's configuration is wrong."""

    fault = CONFIGURATION


class LaunchRefusedError(Gpr20Error, RuntimeError):
    """A robot cannot be launched as requested."""

    fault = NOT_ALLOWED


class OldLaunchError(Gpr20Error, ValueError):
    """A launch file of the original software cannot be imported."""

    fault = NOT_ALLOWED


class OldElementError(Gpr20Error, ValueError):
    """An element of such a file cannot be understood without the computer of the original."""

    fault = CONFIGURATION
