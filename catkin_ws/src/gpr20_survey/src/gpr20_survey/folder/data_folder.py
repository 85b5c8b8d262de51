"""The folder of the surveys: whether it is the one that was used before, on a disk that fits.

A marker in the folder, and what this computer remembers of its path, tell it from all others.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import re
import tempfile
import uuid
from dataclasses import asdict, dataclass, field
from errno import EBADF, EINVAL, ENOLCK, ENOSYS, EOPNOTSUPP, EPERM, EROFS
from pathlib import Path
from typing import ContextManager, Mapping, NamedTuple, Optional, Tuple

from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import ProcessingError, SurveyRefusedError, storing
from gpr20_survey.files.durable_files import Readers, ensure_folders, replace_file, write_new_file
from gpr20_survey.files.regular_files import read_regular

MARKER_FILE = ".gpr20_data.json"
FORMAT = "gpr20-data/1"
MEMORY_MODE = 0o700
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
    wanted = os.path.realpath(source) if source.startswith("/") else ""
    for link in sorted(links.iterdir()) if links.is_dir() else ():
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
        file = Path(place, "file")
        file.touch()
        descriptor = os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            ability = Message("hard links")
            os.link(str(file), f"{file}2")
            ability = Message("locks of folders")
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            ability = Message("durable folders")
            os.fsync(descriptor)
        except OSError as error:
            if error.errno not in UNSUPPORTED:
                raise
            raise SurveyRefusedError(
                Message(
                    "the file system of {folder} ({kind}) has no {ability}, without which a survey "
                    "is not safe; use a disk with ext4 for the data folder",
                    folder=printable(folder),
                    kind=file_system_of(folder).kind or "?",
                    ability=ability,
                    details=error,
                ),
                fault=faults.FILE_SYSTEM_UNSUITABLE,
            ) from error
        finally:
            os.close(descriptor)


@dataclass(frozen=True)
class Marker:
    """What marks a data folder.

    Attributes:
        identity: UUID of the folder.
        file_system: Identity of the file system on which it was made; empty: not known.
    """

    identity: str = field(metadata={"min_length": 1})
    file_system: str = ""


class _DamagedError(ValueError):
    """A marker, or what is remembered, is not as it was written."""


def read_marker(folder: Path) -> Optional[Marker]:
    return _read(folder / MARKER_FILE)


def write_marker(folder: Path, marker: Marker, replace: bool = False) -> None:
    """Mark a data folder; return when that is durable.

    Raises:
        FileExistsError: It has a marker, and `replace` is false.
    """
    write = replace_file if replace else write_new_file
    write(folder / MARKER_FILE, _encoded(asdict(marker)))


def memory_file(state: Path, path: Path) -> Path:
    """Return the file that remembers, with this computer's state, what was at a path."""
    # One for each, so that two robots never write the same file.
    return state / "data_folders" / f"{hashlib.sha256(os.fsencode(path)).hexdigest()[:32]}.json"


def _encoded(values: Mapping[str, str]) -> bytes:
    return (json.dumps({"format": FORMAT, **values}, indent=2) + "\n").encode("ascii")


def _read(path: Path) -> Optional[Marker]:
    try:
        values = json.loads(read_regular(path, follow_link=False))
        if values["format"] != FORMAT:
            raise ValueError(FORMAT)
        return record_from(Marker, values, "", others=True)
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise _DamagedError(printable(path)) from error


@dataclass(frozen=True)
class DataFolderUse:
    """How a data folder is used."""

    path: Path
    """The folder, absolute."""
    state: Path
    """Folder of what this computer remembers."""
    own_disk: bool = False
    """Whether it must be on a disk of its own."""
    mode: int = Readers.GROUP.folder_mode
    """Of the folder, if it is made."""


class KnownFolder(NamedTuple):
    """A data folder with which nothing is wrong."""

    identity: str
    """As its marker has it; empty before the first use."""
    remembered: bool
    """Whether it was used before here."""


class DataFolder:
    """Makes and marks the folder at its first use, and from then on accepts no other.

    What is remembered is outside of the folder, by its path. A path that was never used gets its
    marker when it is checked; where a folder was used before, one without its marker is refused,
    and nothing is made in its place.
    """

    def __init__(self, use: DataFolderUse) -> None:
        self._use = use
        self._path = use.path
        self._memory = memory_file(use.state, use.path)
        self._suitable_device: Optional[int] = None

    def identify(self) -> KnownFolder:
        """Return what the folder is; write nothing.

        Raises:
            SurveyRefusedError: It is not the one that was used before, or on the wrong disk.
            StorageFailedError: It cannot be read, or not be written to.
        """
        with self._using():
            system = self._system()
            known = self._known(system)
            if system.read_only:
                raise OSError(EROFS, os.strerror(EROFS))
        return known

    def check(self) -> None:
        """Make sure that surveys may be stored in the folder; mark it at its first use.

        Raises:
            SurveyRefusedError: It is not the one that was used before, or on a wrong disk.
            StorageFailedError: It cannot be made, read, or written to.
        """
        known = self.identify()
        self.check_file_system()
        if not known.identity:
            # Another program may use it first at this moment.
            with self._using(), contextlib.suppress(FileExistsError):
                self._new_marker()
            known = self.identify()
        if not known.remembered:
            with self._using():
                self._remember(known.identity)

    def accept(self) -> str:
        """Make the folder at this path the one that is used from now on; return its identity.

        Raises:
            SurveyRefusedError: It is on a wrong disk.
            StorageFailedError: It cannot be made, read, or written to.
        """
        with self._using():
            system = self._system()
            check_can_store(existing_folder(self._path))
            try:
                marker = read_marker(self._path)
            except _DamagedError:
                marker = None
            if marker is None or system.is_other_than(marker.file_system):
                marker = self._new_marker(replace=True)
            self._remember(marker.identity)
        return marker.identity

    def problem(self) -> Optional[Message]:
        """Return why surveys cannot be stored, with its fault; None if they can.

        The file system is tried by writing only until it was found suitable, or if it is another.
        """
        try:
            self.identify()
            with self._using():
                device = existing_folder(self._path).stat().st_dev
            if device != self._suitable_device:
                self.check_file_system()
                self._suitable_device = device
        except ProcessingError as error:
            return error.message
        return None

    def check_file_system(self) -> None:
        """Make sure that the file system can hold surveys; leave nothing behind.

        Raises:
            SurveyRefusedError: It lacks something.
            StorageFailedError: It cannot be written to.
        """
        with self._using():
            check_can_store(existing_folder(self._path))

    def _system(self) -> FileSystem:
        system = file_system_of(existing_folder(self._path))
        if self._use.own_disk and (
            system.kind in IN_MEMORY or system.is_same(file_system_of(ROOT))
        ):
            raise SurveyRefusedError(
                Message(
                    "the data folder {path} is not on a disk of its own, but on the file system of "
                    "{mount_point}",
                    path=printable(self._path),
                    mount_point=printable(system.mount_point),
                    details="storage.yaml: data_disk",
                ),
                fault=faults.NO_DATA_DISK,
            )
        return system

    def _known(self, system: FileSystem) -> KnownFolder:
        expected: Optional[str] = "?"
        try:
            remembered = _read(self._memory)
            expected = None if remembered is None else remembered.identity
            marker = read_marker(self._path)
        except _DamagedError as error:
            wrong = Message(
                "{file} is damaged or of another version; if this is the folder of the surveys, "
                "run rosrun gpr20_launch robot_config accept_data",
                file=str(error),
            )
        else:
            if marker is None and expected is None:
                return KnownFolder("", remembered=False)
            if marker is None and not self._path.is_dir():
                wrong = Message("it is gone")
            elif marker is None:
                wrong = Message("its marker {file} is missing", file=MARKER_FILE)
            elif expected not in (None, marker.identity):
                wrong = Message("its identity is {identity}", identity=printable(marker.identity))
            elif system.is_other_than(marker.file_system):
                expected = marker.identity
                wrong = Message(
                    "it is a copy on the file system {found}; the original is on {expected}",
                    found=system.identity or system.kind,
                    expected=printable(marker.file_system),
                )
            else:
                return KnownFolder(marker.identity, remembered=expected is not None)
        raise SurveyRefusedError(
            Message(
                "{path} is not the data folder that was used before (identity {expected}): {found}",
                path=printable(self._path),
                expected=expected and printable(expected),
                found=wrong,
            ),
            fault=faults.OTHER_DATA_FOLDER,
        )

    def _new_marker(self, replace: bool = False) -> Marker:
        ensure_folders(self._path, self._use.mode)
        marker = Marker(str(uuid.uuid4()), file_system_of(self._path).identity)
        write_marker(self._path, marker, replace)
        return marker

    def _remember(self, identity: str) -> None:
        ensure_folders(self._memory.parent, MEMORY_MODE)
        remembered = {"identity": identity, "path": printable(self._path)}  # the path for people
        replace_file(self._memory, _encoded(remembered))

    def _using(self) -> ContextManager[None]:
        failure = Message("the data folder {path} cannot be used", path=printable(self._path))
        return storing(failure, self._path)
