"""What the storage refuses and what can fail in it."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path
from typing import Iterator, Optional

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import DISK_FULL, DISK_REFUSES
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable as printable
from gpr20_survey import faults


class ProcessingError(Gpr20Error):
    """Base of every error of the storage; itself: the disk cannot be read."""

    fault = faults.STORAGE_UNREADABLE


class TraceRefusedError(ProcessingError, ValueError):
    """A trace is not allowed as it is; nothing was stored."""

    fault = faults.TRACE_NOT_ALLOWED


class ForeignTraceError(TraceRefusedError):
    """A trace belongs to another survey."""

    fault = faults.FOREIGN_TRACE


class SurveyRefusedError(ProcessingError, ValueError):
    """A survey cannot be opened or closed as requested; nothing was changed."""

    fault = faults.REQUEST_REFUSED


class ManifestDamagedError(ProcessingError, ValueError):
    """A manifest is not as it was written."""

    fault = faults.MANIFEST_DAMAGED


class StorageFailedError(ProcessingError, OSError):
    """The disk refused something; it is not stored and may be stored again."""

    fault = faults.STORAGE_FAILED


class SigningError(ProcessingError):
    """A survey could not be signed, or its signature not be checked; it is stored all the same."""

    fault = faults.NOT_SIGNED


class _FileError(ProcessingError, OSError):
    fault = faults.NOT_A_FILE

    def __init__(self, message: Message, path: Path) -> None:
        super().__init__(message)
        self.filename = str(path)
        self.strerror = message.sentence()


class FileReplacedError(_FileError):
    """The name of an open file now belongs to another file: what is written is lost."""

    fault = faults.FOLDER_MOVED


class IrregularFileError(_FileError):
    """A link, a folder, a pipe or the like is where a file should be."""

    fault = faults.NOT_A_FILE


_ADVICE = {
    errno.ENOSPC: Message("the disk is full; make space and try again").with_fault(DISK_FULL),
    errno.EDQUOT: Message("the disk quota is used up; make space and try again").with_fault(
        DISK_FULL
    ),
    errno.EROFS: Message(
        "the disk is read-only; look for disk errors and mount it writable"
    ).with_fault(DISK_REFUSES),
    errno.EACCES: Message(
        "permission denied; make the folder and its content readable and writable for this user"
    ).with_fault(faults.NOT_PERMITTED),
    errno.EEXIST: Message(
        "a file of this name exists with other content and was left alone; move it out of the "
        "survey's folder and try again"
    ).with_fault(faults.FILE_EXISTS),
    errno.EPERM: Message(
        "not permitted; the folder's content must belong to this user, and its file system must "
        "support hard links"
    ).with_fault(faults.NOT_PERMITTED),
    errno.ENOENT: Message(
        "there is no such file or folder; if the survey's folder was moved or renamed, put it "
        "back, then resume the survey"
    ).with_fault(faults.FOLDER_MOVED),
    errno.EISDIR: Message("this is a folder, not a file; move it away").with_fault(
        faults.NOT_A_FILE
    ),
    errno.ENOTDIR: Message("this is a file, not a folder; move it away").with_fault(
        faults.NOT_A_FILE
    ),
}


@contextlib.contextmanager
def storing(failure: Message, path: Path) -> Iterator[None]:
    """Turn an error of the disk into one with advice on what to do.

    Args:
        failure: What could not be done, with the path: the first half of the sentence.
        path: Where it was done; if an error concerns another file, the message names that too.

    Raises:
        StorageFailedError: The body raised an OSError.
    """
    try:
        yield
    except OSError as error:
        raise StorageFailedError(_failed(failure, path, error)) from error


def _failed(failure: Message, path: Path, error: OSError) -> Message:
    advice = _advice(error)
    # An error of our own has no technical text beside its message.
    details = "" if isinstance(error, ProcessingError) else error
    file = _other_file(error, path)
    if file is None:
        return Message("{failure}: {advice}", failure=failure, advice=advice, details=details)
    return Message(
        "{failure}, at {file}: {advice}",
        failure=failure,
        file=printable(file),
        advice=advice,
        details=details,
    )


def _other_file(error: OSError, path: Path) -> Optional[str]:
    # Of two names the second is the new one, which fails most often.
    file = error.filename2 or error.filename
    # A temporary file has the name of the file that it becomes within its own.
    if not isinstance(file, str) or path.name in os.path.basename(file):
        return None
    return file


def _advice(error: OSError) -> Message:
    if isinstance(error, ProcessingError):
        return error.message
    known = _ADVICE.get(error.errno or 0)
    return known or Message("{reason}; check the disk", reason=os_reason(error))
