"""Faults and errors of the simulated robot itself; `mid.faults` switches those it simulates."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Fault, Message, Severity

FAULTS_SET = Fault(
    "simulator.faults_set",
    Message("When the test is over, end the fault with simulator/set_fault."),
    Severity.WARNING,
)


class SimulatorError(Gpr20Error):
    """Something about the simulated robot was refused or failed."""

    fault = NOT_ALLOWED


class SceneError(SimulatorError, ValueError):
    """A scene file is missing, is not YAML or holds a key or value that is not allowed."""


class FaultError(SimulatorError, ValueError):
    """A fault was asked for that does not exist."""
