"""Outputs that appear under their name only when they are complete."""

from __future__ import annotations

import contextlib
import secrets
import shutil
from pathlib import Path
from typing import Iterator

from gpr20_analysis.errors import ExportError
from gpr20_common.errors import os_reason
from gpr20_common.faults import DISK_FULL
from gpr20_common.message import Message
from gpr20_common.terminal_text import storable

BESIDE = ".gpr20-"
"""Prefix of the temporary folder, beside the output, in which it is written."""


@contextlib.contextmanager
def atomic_output(path: Path, bytes_needed: int = 0) -> Iterator[Path]:
    """Yield a temporary path of the same name to write a file or folder to.

    At the end the output is moved to its path and replaces what exists there. After Ctrl-C or an
    error the former content is unchanged and no partial output is left.

    Args:
        path: File or folder; missing parent folders are created.
        bytes_needed: Refuse at once if less is free, because the HDF5 library crashes when a disk
            becomes full.

    Raises:
        ExportError: The output cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(str(path.parent)).free
        if free < bytes_needed:
            raise ExportError(
                Message(
                    "{path} needs about {needed_mb:.1f} MB, but only {free_mb:.1f} MB are free; "
                    "free some space or choose another place",
                    path=path,
                    needed_mb=bytes_needed / 1e6,
                    free_mb=free / 1e6,
                ),
                fault=DISK_FULL,
            )
        # Not by tempfile: the umask says who may read what is written.
        beside = path.parent / f"{BESIDE}{secrets.token_hex(8)}"
        beside.mkdir()
        try:
            place = beside / storable(path.name)  # some libraries write no other names
            yield place
            put(place, path, beside / "replaced")
        finally:
            shutil.rmtree(str(beside), ignore_errors=True)
    except OSError as error:
        raise ExportError(
            Message(
                "{path} cannot be written: {reason}; check free space and permissions of "
                "{folder}, or choose another place",
                path=path,
                reason=os_reason(error),
                folder=path.absolute().parent,
            )
        ) from error


def put(written: Path, path: Path, replaced: Path) -> None:
    """Move what is written to its path; a folder that is there goes to `replaced`."""
    # A folder cannot be renamed onto another one.
    if path.is_dir():
        path.rename(replaced)
    written.replace(path)
