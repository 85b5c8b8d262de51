"""The errors that GPR-20 raises on purpose, and what the operating system says of its own."""

from __future__ import annotations

import errno
from typing import ClassVar, Optional

from gpr20_common import faults
from gpr20_common.message import Fault, Message, verbatim


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


_REASONS = {
    errno.EACCES: Message("permission denied"),
    errno.ENOSPC: Message("the disk is full").with_fault(faults.DISK_FULL),
    errno.EDQUOT: Message("the disk quota is used up").with_fault(faults.DISK_FULL),
    errno.EROFS: Message("the disk is read-only").with_fault(faults.DISK_REFUSES),
    errno.EIO: Message("the disk or device has an input/output error"),
    errno.EEXIST: Message("the file exists already"),
    errno.ENOENT: Message("there is no such file or folder"),
    errno.ENOTDIR: Message("this is a file, not a folder"),
    errno.ECONNREFUSED: Message("connection refused"),
    errno.ECONNRESET: Message("the connection was closed by the other side"),
    errno.EPIPE: Message("the connection was closed by the other side"),
    errno.EHOSTUNREACH: Message("no route to this address"),
    errno.ENETUNREACH: Message("the network is unreachable"),
    errno.ETIMEDOUT: Message("no answer in time"),
}


def os_reason(error: OSError) -> Message:
    """Return why something failed, with the system's own words among the details."""
    if isinstance(error, Gpr20Error):
        return error.message
    timed_out = isinstance(error, TimeoutError) and error.errno is None
    known = _REASONS.get(errno.ETIMEDOUT if timed_out else error.errno or 0)
    if known is None:
        return verbatim(error.strerror or str(error) or type(error).__name__)
    return Message("{reason}", reason=known, details=str(error))
