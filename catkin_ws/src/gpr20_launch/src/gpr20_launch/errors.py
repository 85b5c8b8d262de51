"""Errors of a launch."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error


class ConfigurationError(Gpr20Error, ValueError):
    """A file of the robot's configuration is wrong."""


class LaunchRefusedError(Gpr20Error, RuntimeError):
    """A robot cannot be launched as requested."""
