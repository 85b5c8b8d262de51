"""What the storage refuses and what can fail in it."""

from __future__ import annotations

import contextlib
import errno
from pathlib import Path
from typing import Iterator

from gpr20_common.errors import Gpr20Error


class ProcessingError(Gpr20Error):
    """Base of every error of the storage."""


class TraceRefusedError(ProcessingError, ValueError):
    """A trace is not allowed as it is; nothing was stored."""


class SurveyRefusedError(ProcessingError, ValueError):
    """A survey cannot be opened or closed as it was asked for; nothing was changed."""


class StorageFailedError(ProcessingError, OSError):
    """The disk did not take something; it is not stored and may be stored again."""


_ADVICE = {
    errno.ENOSPC: "the disk is full; make space and store again",
    errno.EDQUOT: "the disk quota is used up; make space and store again",
    errno.EROFS: "the disk is read-only; look for disk errors with dmesg and mount it writable",
    errno.EACCES: "permission denied; make the folder writable for this user",
    errno.EEXIST: "a file of this name exists with other content and was left alone; "
    "move it out of the survey's folder and store again",
    errno.EPERM: "not permitted; the folder must be writable and its file system know hard links",
}


@contextlib.contextmanager
def storing(what: str, path: Path) -> Iterator[None]:
    """Turn an error of the disk into one that says what to do.

    Args:
        what: What is written, for the message.
        path: Where it is written.

    Raises:
        StorageFailedError: The body raised an OSError.
    """
    try:
        yield
    except OSError as error:
        advice = _ADVICE.get(error.errno or 0, f"{error.strerror or error}; check the disk")
        raise StorageFailedError(f"{what} could not be written to {path}: {advice}") from error
