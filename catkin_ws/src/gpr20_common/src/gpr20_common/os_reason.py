"""What the operating system says of an error, as a sentence that can be translated."""

from __future__ import annotations

import errno

from gpr20_common.faults import DISK_FULL, DISK_REFUSES
from gpr20_common.message import Message, verbatim

_REASONS = {
    errno.EACCES: Message("permission denied"),
    errno.EPERM: Message("not permitted"),
    errno.ENOSPC: Message("the disk is full").with_fault(DISK_FULL),
    errno.EDQUOT: Message("the disk quota is used up").with_fault(DISK_FULL),
    errno.EROFS: Message("the disk is read-only").with_fault(DISK_REFUSES),
    errno.EIO: Message("the disk or device has an input/output error"),
    errno.EEXIST: Message("the file exists already"),
    errno.ENOENT: Message("there is no such file or folder"),
    errno.ENOTDIR: Message("this is a file, not a folder"),
    errno.EISDIR: Message("this is a folder, not a file"),
    errno.EMFILE: Message("too many files are open"),
    errno.ECONNREFUSED: Message("connection refused"),
    errno.ECONNRESET: Message("the connection was closed by the other side"),
    errno.EPIPE: Message("the connection was closed by the other side"),
    errno.EHOSTUNREACH: Message("no route to this address"),
    errno.ENETUNREACH: Message("the network is unreachable"),
    errno.ETIMEDOUT: Message("no answer in time"),
}


def os_reason(error: OSError) -> Message:
    """Return why something failed, with the system's own words among the details."""
    # One of our own says itself why.
    message = getattr(error, "message", None)
    if isinstance(message, Message):
        return message
    if isinstance(error, TimeoutError) and error.errno is None:
        return Message("no answer in time", details=str(error))
    known = _REASONS.get(error.errno or 0)
    if known is None:
        return verbatim(error.strerror or str(error) or type(error).__name__)
    return Message("{reason}", reason=known, details=str(error))
