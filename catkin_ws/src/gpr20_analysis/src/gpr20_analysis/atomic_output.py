"""Outputs that take their name only when they are whole."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from pathlib import Path
from typing import Iterator

from gpr20_analysis.errors import ExportError

BESIDE = ".gpr20-"
"""Begins the name of the folder in which an output is written, beside its place."""


@contextlib.contextmanager
def atomic_output(path: Path, bytes_needed: int = 0) -> Iterator[Path]:
    """Yield the place where a file or folder is to be written, of the same name.

    At the end it is moved to its path, where it replaces what is there. Ctrl-C or an error leaves
    what was there as it was, and nothing half written.

    Args:
        path: File or folder; folders above it are made.
        bytes_needed: Refuse at once if less is free. HDF5 needs it: its library crashes when a
            disk becomes full.

    Raises:
        ExportError: The disk refused.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(str(path.parent)).free
        if free < bytes_needed:
            raise ExportError(
                f"{path} needs about {bytes_needed / 1e6:.1f} MB, but {free / 1e6:.1f} MB are free "
                "there; make space, or name another place"
            )
        beside = Path(tempfile.mkdtemp(prefix=BESIDE, dir=str(path.parent)))
    except OSError as error:
        raise ExportError(_refusal(path, error)) from error
    try:
        yield beside / path.name
        _put(beside / path.name, path, beside / "replaced")
    except OSError as error:
        raise ExportError(_refusal(path, error)) from error
    finally:
        shutil.rmtree(str(beside), ignore_errors=True)


def _put(written: Path, path: Path, replaced: Path) -> None:
    # A folder cannot be renamed onto another one.
    if path.is_dir():
        path.rename(replaced)
    written.replace(path)


def _refusal(path: Path, error: OSError) -> str:
    return (
        f"{path} cannot be written ({error.strerror or error}); look for space and permission "
        f"in {path.absolute().parent}, or name another place"
    )
