"""What the storage refuses and what can fail in it."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path
from typing import Iterator, Optional

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import DISK_REFUSES, FILE_DAMAGED, INTERNAL, NOT_ALLOWED
from gpr20_common.message import Fault, Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults


class ProcessingError(Gpr20Error):
    """Base of every error of the storage; itself: the disk refuses to read or to write."""

    fault = DISK_REFUSES


class TraceRefusedError(ProcessingError, ValueError):
    """A trace is not allowed as it is; nothing was stored."""

    fault = INTERNAL


class ForeignTraceError(TraceRefusedError):
    """A trace belongs to another survey."""

    fault = faults.DAMAGED


class SurveyRefusedError(ProcessingError, ValueError):
    """A survey cannot be opened or closed as requested; nothing was changed."""

    fault = NOT_ALLOWED


class ManifestDamagedError(ProcessingError, ValueError):
    """A manifest is not as it was written."""

    fault = faults.MANIFEST_DAMAGED


class StorageFailedError(ProcessingError, OSError):
    """The disk refused something; it is not stored and may be stored again."""


class SigningError(ProcessingError):
    """A survey could not be signed, or its signature not be checked; it is stored all the same."""

    fault = faults.NOT_SIGNED


class IrregularFileError(ProcessingError, OSError):
    """A link, a folder, a pipe, or another file than it was, is where a file should be."""

    fault = FILE_DAMAGED

    def __init__(self, message: Message, path: Path, fault: Optional[Fault] = None) -> None:
        super().__init__(message, fault)
        self.filename = str(path)
        self.strerror = message.sentence()


_FAULTS = {
    errno.EACCES: DISK_REFUSES,
    errno.EPERM: DISK_REFUSES,
    errno.EEXIST: faults.FILE_EXISTS,
    errno.ENOENT: faults.FOLDER_MOVED,
    errno.EISDIR: FILE_DAMAGED,
    errno.ENOTDIR: FILE_DAMAGED,
}


@contextlib.contextmanager
def storing(failure: Message, path: Path) -> Iterator[None]:
    """Turn an error of the disk into one with a fault that knows what to do.

    Args:
        failure: What could not be done, with the path: the first half of the sentence.
        path: Where it was done; if an error concerns another file, the message names that too.

    Raises:
        StorageFailedError: The body raised an OSError.
    """
    try:
        yield
    except OSError as error:
        reason = os_reason(error)
        if reason.fault is None:
            reason = reason.with_fault(_FAULTS.get(error.errno or 0))
        raise StorageFailedError(_failed(failure, path, error, reason)) from error


def _failed(failure: Message, path: Path, error: OSError, reason: Message) -> Message:
    # Of two names the second is the new one, which fails most often.
    file = error.filename2 or error.filename
    # A temporary file has the name of the file that it becomes within its own.
    if not isinstance(file, str) or path.name in os.path.basename(file):
        return Message("{failure}: {reason}", failure=failure, reason=reason)
    return Message(
        "{failure}, at {file}: {reason}", failure=failure, file=printable(file), reason=reason
    )
