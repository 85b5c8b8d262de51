"""What the storage refuses and what can fail in it."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path
from typing import Iterator

from gpr20_common.errors import Gpr20Error


class ProcessingError(Gpr20Error):
    """Base of every error of the storage."""


class TraceRefusedError(ProcessingError, ValueError):
    """A trace is not allowed as it is; nothing was stored."""


class ForeignTraceError(TraceRefusedError):
    """A trace belongs to another survey."""


class SurveyRefusedError(ProcessingError, ValueError):
    """A survey cannot be opened or closed as it was asked for; nothing was changed."""


class StorageFailedError(ProcessingError, OSError):
    """The disk did not take something; it is not stored and may be stored again."""


class FileReplacedError(ProcessingError, OSError):
    """An open file is no longer the one of its name: what is written into it is lost."""


class IrregularFileError(ProcessingError, OSError):
    """A link, a folder, a pipe or the like is where a file should be."""


_ADVICE = {
    errno.ENOSPC: "the disk is full; make space and store again",
    errno.EDQUOT: "the disk quota is used up; make space and store again",
    errno.EROFS: "the disk is read-only; look for disk errors with dmesg and mount it writable",
    errno.EACCES: "permission denied; make the folder and what is in it readable and writable "
    "for this user",
    errno.EEXIST: "a file of this name exists with other content and was left alone; "
    "move it out of the survey's folder and store again",
    errno.EPERM: "not permitted; what is in the folder must belong to this user, and its file "
    "system know hard links",
    errno.ENOENT: "it is gone; if the survey's folder was moved or renamed, put it back, "
    "then resume the survey",
    errno.EISDIR: "this is a folder, no file; move it away",
    errno.ENOTDIR: "this is a file, no folder; move it away",
}


@contextlib.contextmanager
def storing(what: str, path: Path, failed: str = "be written to") -> Iterator[None]:
    """Turn an error of the disk into one that says what to do.

    Args:
        what: What is written, for the message.
        path: Where it is written.
        failed: What could not be done, if it is no writing.

    Raises:
        StorageFailedError: The body raised an OSError.
    """
    try:
        yield
    except OSError as error:
        place = f"{printable(str(path))}{_file_of(error, path)}"
        raise StorageFailedError(f"{what} could not {failed} {place}: {_advice(error)}") from error


def printable(name: str) -> str:
    """Return a file's name as text that can be sent and shown, whatever bytes it holds."""
    return os.fsencode(name).decode("utf-8", "backslashreplace")


def _file_of(error: OSError, path: Path) -> str:
    # Of two names the second is the new one, which is what fails most often.
    file = error.filename2 or error.filename
    # A temporary file has the name of what it shall become within its own.
    if not isinstance(file, str) or path.name in os.path.basename(file):
        return ""
    return f" (at {printable(file)})"


def _advice(error: OSError) -> str:
    if isinstance(error, (IrregularFileError, FileReplacedError)):
        return str(error.strerror)
    return _ADVICE.get(error.errno or 0, f"{error.strerror or error}; check the disk")
