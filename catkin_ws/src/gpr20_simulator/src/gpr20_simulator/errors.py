"""Errors of the simulated robot."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_simulator import faults


class SimulatorError(Gpr20Error):
    """Something about the simulated robot was refused or failed."""

    fault = faults.NO_CAPTURE_FOLDER


class SceneError(SimulatorError, ValueError):
    """A scene file is missing, is not YAML or holds a key or value that is not allowed."""

    fault = faults.WRONG_SCENE


class FaultError(SimulatorError, ValueError):
    """A fault was asked for that does not exist."""

    fault = faults.UNKNOWN_FAULT


class MediumError(SimulatorError, ValueError):
    """The medium in front of the antennas was asked for by an unknown name."""

    fault = faults.UNKNOWN_MEDIUM
