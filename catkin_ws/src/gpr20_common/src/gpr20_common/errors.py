"""The root of every error that GPR-20 raises on purpose."""

from __future__ import annotations

from typing import ClassVar, Optional

from gpr20_common import faults
from gpr20_common.message import Fault, Message

# What reading something that anybody may have written can raise.
UNREADABLE = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)


class Gpr20Error(Exception):
    """Something was refused or failed; the message says what, why and what to do.

    Each package derives one error of its own from this one. The high levels catch
    this class in one place and hand its message to the operator. The message reports the fault of
    the class, or a finer one that a raise names, unless it came with one.
    """

    fault: ClassVar[Fault] = faults.INTERNAL
    message: Message

    def __init__(self, message: Message, fault: Optional[Fault] = None) -> None:
        if fault is not None or message.fault is None:
            message = message.with_fault(fault or self.fault)
        super().__init__(message)
        self.message = message

    def __str__(self) -> str:
        return str(self.message)


class InvalidValueError(Gpr20Error, ValueError):
    """A value that came from outside is not allowed."""

    fault = faults.NOT_ALLOWED


class ConfigurationError(InvalidValueError):
    """What the configuration of a robot or of a computer says is not allowed."""

    fault = faults.CONFIGURATION


class NodeSilentError(Gpr20Error, OSError):
    """A node does not answer."""

    fault = faults.PART_SILENT


class NodeGoneError(NodeSilentError):
    """A node has ended: nothing listens at its address, or the master does not know it."""
