"""The faults of the simulated robot itself; `mid.faults` switches those that it simulates."""

from __future__ import annotations

from gpr20_common.message import Fault, Message, Severity

FAULTS_SET = Fault(
    "simulator.faults_set",
    Message("When the test is over, end the fault with simulator/set_fault."),
    Severity.WARNING,
)
