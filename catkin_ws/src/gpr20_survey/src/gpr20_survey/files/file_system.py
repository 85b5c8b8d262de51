"""The file system of a folder: which one it is, and whether it can hold surveys."""

from __future__ import annotations

import fcntl
import os
import re
import tempfile
from dataclasses import dataclass
from errno import EBADF, EINVAL, ENOLCK, ENOSYS, EOPNOTSUPP, EPERM
from pathlib import Path
from typing import Callable, Tuple

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError

ROOT = Path("/")
IN_MEMORY = ("ramfs", "tmpfs")
# What the system answers where something is not supported; a FAT answers EPERM to link().
UNSUPPORTED = (EBADF, EINVAL, ENOLCK, ENOSYS, EOPNOTSUPP, EPERM)


@dataclass(frozen=True)
class FileSystem:
    """What is known about a file system.

    Attributes:
        device: Its number until the next restart.
        mount_point: Where it begins.
        kind: Such as ext4; empty: not known.
        identity: Tells it from every other one, also after a restart; empty: not known.
        read_only: Whether nothing can be written.
    """

    device: int
    mount_point: str
    kind: str
    identity: str
    read_only: bool

    def is_same(self, other: FileSystem) -> bool:
        """Return whether both are one."""
        # The subvolumes of a btrfs have different devices.
        return self.device == other.device or self.identity == other.identity != ""

    def is_other_than(self, identity: str) -> bool:
        """Return whether an identity proves to be that of another file system."""
        if self.kind in IN_MEMORY:
            return identity != ""  # it has none, and a disk has one
        return "" not in (identity, self.identity) and identity != self.identity


def existing_folder(path: Path) -> Path:
    """Return a folder, or the nearest one above it that exists."""
    return next(one for one in (path, *path.parents) if one.is_dir())


def file_system_of(folder: Path, root: Path = ROOT) -> FileSystem:
    """Return the file system of a folder that exists; below `root` are /proc and /dev."""
    device = folder.stat().st_dev
    source, point, kind = _mount_of(f"{os.path.realpath(str(folder))}/", root)
    read_only = bool(os.statvfs(str(folder)).f_flag & os.ST_RDONLY)
    return FileSystem(device, point, kind, _uuid(device, source, root), read_only)


def _mount_of(folder: str, root: Path) -> Tuple[str, str, str]:
    """Return source, place and kind of the mount of a folder; empty: not known."""
    found, table = ("", "/", ""), root / "proc/self/mounts"
    lines = table.read_bytes().split(b"\n") if table.exists() else []
    for line in filter(None, lines):
        # "source /point kind options...", with octal numbers for spaces
        source, point, kind = (
            re.sub(r"\\([0-7]{3})", lambda number: chr(int(number.group(1), 8)), one)
            for one in os.fsdecode(line).split(" ")[:3]
        )
        # Of two at the same place the later one hides the other.
        if folder.startswith(f"{point.rstrip('/')}/") and len(point) >= len(found[1]):
            found = (source, point, kind)
    return found


def _uuid(device: int, source: str, root: Path) -> str:
    """Return what udev knows of the device; empty: it is no block device, or nothing is known."""
    links = root / "dev/disk/by-uuid"
    if not links.is_dir():
        return ""
    wanted = os.path.realpath(source) if source.startswith("/") else ""
    for link in sorted(links.iterdir()):
        # A link to a disk that has just been unplugged leads nowhere.
        if link.exists() and (link.stat().st_rdev == device or os.path.realpath(link) == wanted):
            return f"uuid:{link.name}"
    return ""


def check_can_store(folder: Path) -> None:
    """Refuse the file system of a folder if it lacks what makes surveys durable.

    Raises:
        SurveyRefusedError: It has no hard links, no locks, or cannot make names durable.
        OSError: It cannot be written to.
    """
    with tempfile.TemporaryDirectory(prefix=".gpr20-", suffix=".tmp", dir=str(folder)) as place:
        file = os.path.join(place, "file")
        with open(file, "xb"):
            pass
        descriptor = os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            _try(lambda: os.link(file, f"{file}2"), Message("hard links"), folder)
            lock = fcntl.LOCK_EX | fcntl.LOCK_NB
            _try(lambda: fcntl.flock(descriptor, lock), Message("locks of folders"), folder)
            _try(lambda: os.fsync(descriptor), Message("durable folders"), folder)
        finally:
            os.close(descriptor)


def _try(use: Callable[[], None], ability: Message, folder: Path) -> None:
    try:
        use()
    except OSError as error:
        if error.errno not in UNSUPPORTED:
            raise
        raise SurveyRefusedError(
            Message(
                "the file system of {folder} ({kind}) has no {ability}, without which a survey is "
                "not safe; use a disk with ext4 for the data folder",
                folder=printable(folder),
                kind=file_system_of(folder).kind or "?",
                ability=ability,
                details=error,
            ),
            fault=faults.FILE_SYSTEM_UNSUITABLE,
        ) from error
