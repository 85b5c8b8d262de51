"""Errors of a launch."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_launch import faults


class ConfigurationError(Gpr20Error, ValueError):
    """A file of the robot's configuration is wrong."""

    fault = faults.WRONG_VALUE


class LaunchRefusedError(Gpr20Error, RuntimeError):
    """A robot cannot be launched as requested."""

    fault = faults.WRONG_ARGUMENT


class OldLaunchError(Gpr20Error, ValueError):
    """A launch file of the original software cannot be imported."""

    fault = faults.OLD_LAUNCH


class OldElementError(Gpr20Error, ValueError):
    """An element of such a file cannot be understood without the computer of the original."""

    fault = faults.OLD_UNREAD
