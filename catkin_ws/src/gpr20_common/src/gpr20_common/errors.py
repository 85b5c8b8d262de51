"""The root of every error that GPR-20 raises on purpose."""

from __future__ import annotations

from gpr20_common.message import Message


class Gpr20Error(Exception):
    """Something was refused or failed; the message says what, why and what to do.

    Each package derives one error of its own from this one. The high levels catch
    this class in one place and hand its message to the operator.

    Attributes:
        message: What was refused or failed, why, and what to do. Its English text is what
            `str` returns.
    """

    message: Message

    def __init__(self, message: Message) -> None:
        super().__init__(message)
        self.message = message

    def __str__(self) -> str:
        return str(self.message)


class InvalidValueError(Gpr20Error, ValueError):
    """A value that came from outside is not allowed."""


class NodeSilentError(Gpr20Error, OSError):
    """A node does not answer."""


class NodeGoneError(NodeSilentError):
    """A node has ended: nothing listens at its address, or the master does not know it."""
