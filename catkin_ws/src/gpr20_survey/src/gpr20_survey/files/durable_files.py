"""Small files that are on the disk either whole or not at all."""

from __future__ import annotations

import itertools
import os
import secrets
import shutil
from pathlib import Path
from typing import Iterator, Optional

from gpr20_survey.files import access
from gpr20_survey.files.regular_file import open_regular

# Readers take `*.json`; a file that was never finished has neither this start nor this end.
TEMPORARY_PREFIX = "."
TEMPORARY_SUFFIX = ".tmp"


def free_bytes(folder: Path) -> int:
    """Return what may still be written below a folder [bytes].

    Raises:
        OSError: The folder cannot be read.
    """
    return shutil.disk_usage(str(folder)).free


def temporary_path(path: Path) -> Path:
    """Return a free name in the folder of a file; readers ignore it."""
    name = f"{TEMPORARY_PREFIX}{path.name}.{secrets.token_hex(4)}{TEMPORARY_SUFFIX}"
    return path.with_name(name)


def write_new_file(path: Path, data: bytes) -> None:
    """Write a file that must not exist yet; return when it is durable.

    A file that is there already with the same bytes is made durable instead, so that the
    call can be repeated after any failure.

    Raises:
        FileExistsError: The file exists with other content; it is left alone.
        OSError: The disk refused; no file of this name was left half written.
    """
    temporary = _write_temporary(path, data)
    try:
        # Unlike rename(), link() never replaces a file.
        os.link(str(temporary), str(path))
    except FileExistsError:
        if not _holds(path, data):
            raise
        sync_path(path)
    finally:
        temporary.unlink()
    sync_path(path.parent)


def replace_file(path: Path, data: bytes) -> None:
    """Give a file new content in one step; return when it is durable.

    Raises:
        OSError: The disk refused; the file has its former content.
    """
    temporary = _write_temporary(path, data)
    try:
        os.replace(str(temporary), str(path))
    except OSError:
        temporary.unlink()
        raise
    sync_path(path.parent)


def make_new_folder(path: Path, mode: Optional[int] = None) -> None:
    """Make a folder that must not exist yet; return when it is durable.

    Args:
        path: The folder.
        mode: Its mode; None: that of the folder above.

    Raises:
        FileExistsError: The folder exists.
        OSError: The disk refused.
    """
    access.make_folder(path, access.mode_for(path.parent) if mode is None else mode)
    sync_path(path.parent)


def ensure_folder(path: Path, mode: Optional[int] = None) -> None:
    """Make a folder if it is missing; return when it is durable.

    The folder above it is not made: where a disk is missing, nothing begins in its place.

    Args:
        path: The folder.
        mode: Its mode, if it is made; None: that of the folder above it.

    Raises:
        OSError: The disk refused, or the folder above it is missing.
    """
    if not path.is_dir():
        make_new_folder(path, mode)


def ensure_folders(path: Path, mode: Optional[int] = None) -> None:
    """Make a folder and those above it where they are missing; return when all are durable.

    Args:
        path: The folder.
        mode: That of each folder that is made; None: that of the folder above it.

    Raises:
        OSError: The disk refused.
    """
    if not path.is_dir():
        ensure_folders(path.parent, mode)
        make_new_folder(path, mode)


def sync_path(path: Path) -> None:
    """Return when the content of a file, or the names in a folder, are on the disk."""
    descriptor = os.open(str(path), os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _holds(path: Path, data: bytes) -> bool:
    with open(open_regular(path), "rb") as stream:
        return stream.read(len(data) + 1) == data


def write_in_new_folder(path: Path, data: bytes) -> None:
    """Write a new file into a folder that nobody reads yet; return when its content is durable.

    Its name is durable after `sync_path` of the folder.

    Raises:
        FileExistsError: The file exists.
        OSError: The disk refused; the file may be there in part.
    """
    descriptor = access.open_new(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
    with open(descriptor, "wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(descriptor)


def _write_temporary(path: Path, data: bytes) -> Path:
    temporary = temporary_path(path)
    try:
        write_in_new_folder(temporary, data)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
    return temporary


def is_temporary(name: str) -> bool:
    """Return whether a name is that of a file which was never finished."""
    return name.startswith(TEMPORARY_PREFIX) and name.endswith(TEMPORARY_SUFFIX)


def remove_temporaries(folder: Path) -> int:
    """Remove the files that were being written at a crash; return how many.

    A folder with such a name was not made here and is left alone.

    Raises:
        OSError: The disk refused.
    """
    torn = [one for one in folder.iterdir() if is_temporary(one.name) and not _is_folder(one)]
    for one in torn:
        one.unlink()
    return len(torn)


def keep_aside(path: Path, folder: Path) -> Path:
    """Give a file a second, free name in another folder; return it when it is durable.

    Raises:
        OSError: The disk refused.
    """
    ensure_folder(folder)
    for target in _names_for(path, folder):
        try:
            os.link(str(path), str(target), follow_symlinks=False)  # never replaces a file
        except FileExistsError:
            continue
        sync_path(folder)
        return target
    raise AssertionError("numbers do not end")


def _names_for(path: Path, folder: Path) -> Iterator[Path]:
    yield folder / path.name
    for number in itertools.count(1):
        yield folder / f"{path.name}.{number}"


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def move_aside(path: Path, folder: Path) -> Path:
    """Move a file, or whatever is there, into a folder under a free name; return where it is.

    Raises:
        OSError: The disk refused; the file is where it was, or in both places.
    """
    try:
        target = keep_aside(path, folder)
    except PermissionError:
        # A folder has no second name, and the system may refuse one for another user's file.
        target = next(one for one in _names_for(path, folder) if not os.path.lexists(str(one)))
        os.rename(str(path), str(target))
        sync_path(folder)
    else:
        path.unlink()
    sync_path(path.parent)
    return target


def put_in_place(temporary: Path, path: Path) -> None:
    """Give a whole and durable file the name of another; return when that is durable.

    Raises:
        OSError: The disk refused.
    """
    os.replace(str(temporary), str(path))
    sync_path(path.parent)


def remove_file(path: Path) -> None:
    """Remove a file or a link, if it is there; return when that is durable.

    Raises:
        OSError: The disk refused.
    """
    if os.path.lexists(str(path)):
        path.unlink()
        sync_path(path.parent)
