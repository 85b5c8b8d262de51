"""Small files that are on the disk either whole or not at all, lines added to one, and a lock.

Each function returns when what it did is durable, and raises OSError if the disk refuses.

The folder of a survey is made with the mode that the robot's parameters give. Whatever is made in
a folder later follows that folder, so a survey's files always have one mode, also when it is
resumed with other parameters. The umask has no influence.
"""

from __future__ import annotations

import contextlib
import enum
import fcntl
import itertools
import json
import os
import secrets
import shutil
import stat
import time
from pathlib import Path
from typing import Any, Dict, Iterator, Mapping, Optional

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.regular_files import (
    TEMPORARY_PREFIX,
    TEMPORARY_SUFFIX,
    is_temporary,
    read_regular,
)

# What may be taken over from a folder: never the right of everyone to write.
FILE_MODES, FOLDER_MODES = 0o664, 0o775
# How long somebody who adds one fact waits for another who does the same.
SHORT_WAIT_S = 5.0
# `writer_of` holds the lock for a moment.
_LOOK_S = 0.2
_POLL_S = 0.01


class Readers(enum.Enum):
    """Who may read a survey; only its owner may write."""

    OWNER = "owner"
    GROUP = "group"
    ALL = "all"

    @property
    def folder_mode(self) -> int:
        return {Readers.OWNER: 0o700, Readers.GROUP: 0o750, Readers.ALL: 0o755}[self]


def open_new(path: Path, flags: int, mode: Optional[int] = None) -> int:
    """Return the descriptor of a file that is made, with O_CREAT among the flags, if it is missing.

    Its mode is that of its folder, if none is given.
    """
    mode = file_mode_for(path.parent) if mode is None else mode
    descriptor = os.open(str(path), flags | os.O_CLOEXEC | os.O_NOFOLLOW, mode)
    try:
        if flags & os.O_CREAT and stat.S_IMODE(os.fstat(descriptor).st_mode) != mode:
            os.fchmod(descriptor, mode)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def file_mode_for(folder: Path) -> int:
    return folder.stat().st_mode & FILE_MODES


def free_bytes(folder: Path) -> int:
    return shutil.disk_usage(str(folder)).free


def temporary_path(path: Path) -> Path:
    """Return a free name in the folder of a file; readers ignore it."""
    name = f"{TEMPORARY_PREFIX}{path.name}.{secrets.token_hex(4)}{TEMPORARY_SUFFIX}"
    return path.with_name(name)


def remove_temporaries(folder: Path) -> int:
    """Remove the files that were being written at a crash; return how many.

    A folder with such a name was not made here and is left alone.
    """
    torn = [one for one in folder.iterdir() if is_temporary(one.name)]
    torn = [one for one in torn if one.is_symlink() or not one.is_dir()]
    for one in torn:
        one.unlink()
    return len(torn)


def write_new_file(path: Path, data: bytes) -> None:
    """Write a file that must not exist yet.

    A file that is there already with the same bytes is made durable instead, so that the
    call can be repeated after any failure.

    Raises:
        FileExistsError: The file exists with other content; it is left alone.
    """
    temporary = _write_temporary(path, data)
    try:
        # Unlike rename(), link() never replaces a file.
        os.link(str(temporary), str(path))
    except FileExistsError:
        if read_regular(path, follow_link=False) != data:
            raise
        sync_path(path)
    finally:
        temporary.unlink()
    sync_path(path.parent)


def replace_file(path: Path, data: bytes) -> None:
    """Give a file new content in one step; after an error it has its former content."""
    temporary = _write_temporary(path, data)
    try:
        put_in_place(temporary, path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


def put_in_place(temporary: Path, path: Path) -> None:
    """Give a whole and durable file the name of another."""
    os.replace(str(temporary), str(path))
    sync_path(path.parent)


def write_in_new_folder(path: Path, data: bytes) -> None:
    """Write a new file into a folder that nobody reads yet.

    Its name is durable after `sync_path` of the folder; after an error it may be there in part.
    """
    descriptor = open_new(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
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


def make_new_folder(path: Path, mode: Optional[int] = None) -> None:
    """Make a folder that must not exist yet; without a mode it gets that of the folder above.

    A group that it inherits from there is kept.

    Raises:
        FileExistsError: The folder exists.
    """
    mode = path.parent.stat().st_mode & FOLDER_MODES if mode is None else mode
    path.mkdir(mode)
    made = stat.S_IMODE(path.stat().st_mode)
    if made & 0o777 != mode & 0o777:
        path.chmod(mode & 0o777 | made & stat.S_ISGID)
    sync_path(path.parent)


def ensure_folder(path: Path, mode: Optional[int] = None) -> None:
    """Make a folder if it is missing.

    That above it is not made: where a disk is missing, nothing begins in its place.
    """
    if not path.is_dir():
        make_new_folder(path, mode)


def ensure_folders(path: Path, mode: Optional[int] = None) -> None:
    """Make a folder and those above it where they are missing."""
    if not path.is_dir():
        ensure_folders(path.parent, mode)
        ensure_folder(path, mode)


def sync_path(path: Path) -> None:
    """Return when the content of a file, or the names in a folder, are on the disk."""
    descriptor = os.open(str(path), os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def keep_aside(path: Path, folder: Path) -> Path:
    """Give a file a second, free name in another folder, and return it.

    What can have only one name, such as a folder, is moved there.
    """
    ensure_folder(folder)
    numbered = (folder / f"{path.name}.{number}" for number in itertools.count(1))
    names = itertools.chain([folder / path.name], numbered)
    target = next(one for one in names if not os.path.lexists(str(one)))
    try:
        os.link(str(path), str(target), follow_symlinks=False)
    except PermissionError:
        os.rename(str(path), str(target))
    sync_path(folder)
    return target


def move_aside(path: Path, folder: Path) -> Path:
    """Move a file, or whatever is there, into a folder under a free name, and return it.

    After an error it is where it was, or in both places.
    """
    target = keep_aside(path, folder)
    path.unlink(missing_ok=True)
    sync_path(path.parent)
    return target


def remove_file(path: Path) -> None:
    """Remove a file or a link, if it is there."""
    if os.path.lexists(str(path)):
        path.unlink()
        sync_path(path.parent)


def lines_backwards(*paths: Path) -> Iterator[bytes]:
    """Yield the lines of those files that exist, the last line of the first file first."""
    for path in paths:
        with contextlib.suppress(FileNotFoundError):
            yield from reversed(read_regular(path).splitlines())


def add_line(path: Path, values: Mapping[str, Any], mode: Optional[int] = None) -> None:
    """Add an object to a file and return when it is durable.

    File and folder are made if they are missing, the file with this mode or that of its folder.

    Raises:
        OSError: The disk refused; a part of the line may be there.
        ValueError: A number is not finite.
    """
    ensure_folder(path.parent)
    line = json.dumps(values, allow_nan=False).encode() + b"\n"
    append_line(path, line, os.O_CREAT, mode)
    sync_path(path.parent)


def append_line(path: Path, line: bytes, flags: int = 0, mode: Optional[int] = None) -> None:
    """Add a line to a file and return when it is durable; only with O_CREAT it may be missing.

    Raises:
        OSError: The disk refused; a part of the line may be there.
    """
    descriptor = open_new(path, os.O_RDWR | os.O_APPEND | flags, mode)
    with os.fdopen(descriptor, "r+b", buffering=0) as file:
        end = file.seek(0, os.SEEK_END)
        # A line that a crash has cut is left as it is, and damages no other.
        if end and os.pread(descriptor, 1, end - 1) != b"\n":
            line = b"\n" + line
        if file.write(line) != len(line):
            raise OSError(f"{path}: the disk took a part of the line")
        os.fsync(descriptor)


def object_of(line: bytes) -> Dict[str, Any]:
    """Return the object of a line; it is empty if the line has none."""
    found = None
    with contextlib.suppress(ValueError):
        found = json.loads(line)
    return found if isinstance(found, dict) else {}


@contextlib.contextmanager
def locked(folder: Path, wait_s: float = _LOOK_S) -> Iterator[None]:
    """Hold the lock of a survey's folder, as every writer of it does; readers need not.

    It ends with the process at the latest.

    Raises:
        SurveyRefusedError: Another process holds it, also after `wait_s`.
        OSError: The folder cannot be opened or locked.
    """
    descriptor = os.open(str(folder), os.O_RDONLY | os.O_DIRECTORY)
    try:
        deadline_s = time.monotonic() + wait_s
        while not _take(descriptor, fcntl.LOCK_EX):
            if time.monotonic() >= deadline_s:
                raise SurveyRefusedError(
                    Message(
                        "the survey in {folder} is being written by another process ({process}), "
                        "for example by another robot with the same data folder; end the survey "
                        "there first, or the process if it hangs",
                        folder=printable(folder),
                        process=_holder(descriptor),
                    ),
                    fault=faults.LOCKED,
                )
            time.sleep(_POLL_S)
        yield
    finally:
        os.close(descriptor)


def writer_of(folder: Path) -> Optional[str]:
    """Return the number of the process that writes a survey's folder; None: nobody does."""
    descriptor = os.open(str(folder), os.O_RDONLY | os.O_DIRECTORY)
    try:
        return None if _take(descriptor, fcntl.LOCK_SH) else _holder(descriptor)
    finally:
        os.close(descriptor)


def _take(descriptor: int, kind: int) -> bool:
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _holder(descriptor: int) -> str:
    """Return the number of the process that holds a lock; "?" if this system does not show it."""
    # Lines as "1: FLOCK  ADVISORY  WRITE 4711 00:2a:52 0 EOF", with the inode after the device.
    inode = str(os.fstat(descriptor).st_ino)
    locks = Path("/proc/locks")
    lines = locks.read_text(encoding="ascii").splitlines() if locks.exists() else []
    found = [one for one in map(str.split, lines) if one[1] == "FLOCK"]
    return next((one[4] for one in found if one[5].split(":")[-1] == inode), "?")
