"""The USB sticks of the computer, by lsblk, and the files that are written on them.

A file has its name only when it is whole and on the stick. The mount point and the folder of the
exports are opened once, without following links, and everything else is named relative to them:
what is put there meanwhile, or instead of the stick, leads to no other disk.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import hashlib
import json
import os
import secrets
import stat
import subprocess
from pathlib import Path
from typing import IO, Any, Callable, Dict, Iterator, List, Tuple

from gpr20_common.faults import NOT_SET_UP
from gpr20_common.message import Message
from gpr20_imaging.faults import ImagingError, StickError
from gpr20_survey.results.answers import Volume

COMMAND = (
    *("lsblk", "--json", "--bytes"),
    *("--output", "NAME,LABEL,RM,HOTPLUG,TRAN,RO,MOUNTPOINT"),
)
LIMIT_S = 10.0
# Where desktops, servers and people mount sticks; never a disk of the system.
MOUNT_FOLDERS = (Path("/media"), Path("/run/media"), Path("/mnt"))


def list_block_devices() -> str:
    """Return what lsblk prints as JSON."""
    return subprocess.check_output(
        COMMAND, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=LIMIT_S, text=True
    )


class UsbVolumes:
    """Finds the sticks.

    Args:
        list_devices: Returns the JSON of lsblk.
        mount_folders: Folders below which sticks are mounted.
    """

    def __init__(
        self,
        list_devices: Callable[[], str] = list_block_devices,
        mount_folders: Tuple[Path, ...] = MOUNT_FOLDERS,
    ) -> None:
        self._list_devices = list_devices
        self._mount_folders = mount_folders

    def mounted(self) -> List[Volume]:
        """Return every mounted stick.

        Raises:
            ImagingError: They cannot be listed.
        """
        try:
            devices = json.loads(self._list_devices())["blockdevices"]
            found = [
                (Path(one["mountpoint"]), str(one.get("label") or one["name"]), one)
                for one in _removable(devices, False)
                if one.get("mountpoint")
            ]
        except (
            OSError, subprocess.SubprocessError, ValueError, KeyError, TypeError, AttributeError
        ) as error:  # fmt: skip
            raise ImagingError(
                Message(
                    "the program lsblk does not list the USB sticks of this computer",
                    details=error,
                ),
                fault=NOT_SET_UP,
            ) from error
        return [
            volume
            for path, name, device in found
            if any(folder in path.parents for folder in self._mount_folders)
            for volume in _volume(path, name, _flag(device.get("ro")))
        ]

    def find(self, path: str) -> Volume:
        """Return a mounted stick by its path.

        Raises:
            ImagingError: There is none.
        """
        for volume in self.mounted():
            if volume.path == path:
                return volume
        raise StickError(
            Message(
                "the USB stick at {path} is not mounted any more; plug it in",
                path=repr(path[:200]),
            ),
        )


def _removable(devices: List[Dict[str, Any]], inherited: bool) -> Iterator[Dict[str, Any]]:
    """Yield devices that can be pulled out, and their partitions."""
    for device in devices:
        removable = (
            inherited
            or device.get("tran") == "usb"
            or _flag(device.get("rm"))
            or _flag(device.get("hotplug"))
        )
        if removable:
            yield device
        yield from _removable(device.get("children") or [], removable)


def _flag(value: object) -> bool:
    # Older versions print "1" and "0".
    return value is True or value == "1"


def _volume(path: Path, name: str, read_only: bool) -> Iterator[Volume]:
    try:
        status, room = path.stat(), os.statvfs(str(path))
    except OSError:
        return  # it was pulled out since lsblk has listed it
    yield Volume(
        path=str(path),
        name=name,
        free_bytes=room.f_bavail * room.f_frsize,
        writable=not read_only and os.access(str(path), os.W_OK),
        device=status.st_dev,
    )


PIECE_BYTES = 1 << 20
SUM = ".sha256"
# A link, or a file.
NO_FOLDER = (errno.ELOOP, errno.ENOTDIR)
FOLDER_FLAGS = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
NEW_FILE_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
OLD_FILE_FLAGS = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
# Of the name of what is being written.
TEMPORARY = ".gpr20_export_"


class SummedFile:
    """A file that is written from its beginning to its end, and its checksum.

    It has neither `tell` nor `seek`, so that a ZIP file goes into it in one pass.

    Args:
        stream: Where the bytes go.

    Attributes:
        digest: SHA-256 of what was written.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self.digest = hashlib.sha256()

    def write(self, data: bytes) -> int:
        """Write bytes.

        Raises:
            OSError: The stick refused.
        """
        self.digest.update(data)
        return self._stream.write(data)

    def flush(self) -> None:
        """Pass everything to the system."""
        self._stream.flush()


class StickFolder:
    """The folder of the exports on a stick; a context that closes it.

    Args:
        volume: The stick.
        name: Of the folder, which is made if it is missing.

    Raises:
        ImagingError: The stick was removed, or something else has the name.
        OSError: The stick refused.
    """

    def __init__(self, volume: Volume, name: str) -> None:
        self._volume, self._name = volume, name
        self._sums: Dict[str, str] = {}  # SHA-256 of each file that has its name
        with contextlib.ExitStack() as opened:
            self._root = os.open(volume.path, FOLDER_FLAGS)
            opened.callback(os.close, self._root)
            if os.fstat(self._root).st_dev != volume.device:
                raise self._gone()
            with contextlib.suppress(FileExistsError):
                os.mkdir(name, dir_fd=self._root)
            try:
                self._folder = os.open(name, FOLDER_FLAGS, dir_fd=self._root)
            except OSError as error:
                if error.errno in NO_FOLDER:
                    raise self._no_folder() from error
                raise
            opened.callback(os.close, self._folder)
            if os.fstat(self._folder).st_dev != volume.device:
                raise self._no_folder()
            self._opened = opened.pop_all()

    def __enter__(self) -> StickFolder:
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def remove_unfinished(self) -> None:
        """Remove what an interrupted export left.

        Raises:
            OSError: The stick refused.
        """
        for name in os.listdir(self._folder):
            if name.startswith(TEMPORARY):
                os.unlink(name, dir_fd=self._folder)

    @contextlib.contextmanager
    def new_file(self, name: str) -> Iterator[SummedFile]:
        """Write a file and its checksum file; both replace older ones when the block ends.

        After an error neither has changed, and nothing unfinished is left, if the stick is still
        there.

        Raises:
            OSError: The stick refused.
        """
        temporary, temporary_sum = (f"{TEMPORARY}{secrets.token_hex(8)}" for _ in range(2))
        try:
            with self._new(temporary) as stream:
                file = SummedFile(stream)
                yield file
                _sync(stream)
            line = f"{file.digest.hexdigest()}  {name}\n".encode()
            with self._new(temporary_sum) as stream:
                stream.write(line)
                _sync(stream)
            # That of the former content must never stand beside the new one.
            with contextlib.suppress(FileNotFoundError):
                os.unlink(name + SUM, dir_fd=self._folder)
            self._put(temporary, name)
            self._put(temporary_sum, name + SUM)
            self._sums[name] = file.digest.hexdigest()
            self._sums[name + SUM] = hashlib.sha256(line).hexdigest()
        finally:
            for one in (temporary, temporary_sum):
                # A stick that was pulled out has no files to remove; the reason is on its way
                # already.
                with contextlib.suppress(OSError):
                    os.unlink(one, dir_fd=self._folder)

    def sync(self) -> None:
        """Return when everything of the stick is on it, so that it can be pulled out.

        Raises:
            OSError: The stick refused, or was pulled out.
        """
        if ctypes.CDLL(None, use_errno=True).syncfs(self._folder) != 0:
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number))

    def check_in_place(self) -> None:
        """Check that the stick still has its name.

        Raises:
            ImagingError: Something else has it.
            OSError: The stick was removed.
        """
        there = os.stat(self._volume.path, follow_symlinks=False)
        if not os.path.samestat(there, os.fstat(self._root)):
            raise self._gone()

    def check_written(self) -> None:
        """Read all that was written from the stick and compare it; `sync` must have returned.

        Raises:
            ImagingError: The stick does not hold it.
            OSError: A file cannot be read.
        """
        for name, expected in self._sums.items():
            with open(os.open(name, OLD_FILE_FLAGS, dir_fd=self._folder), "rb") as stream:
                if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                    raise self._differs(name)
                # What the system still has in memory would say nothing about the stick.
                os.posix_fadvise(stream.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
                digest = hashlib.sha256()
                for piece in iter(lambda: stream.read(PIECE_BYTES), b""):
                    digest.update(piece)
            if digest.hexdigest() != expected:
                raise self._differs(name)

    def _new(self, name: str) -> IO[bytes]:
        return open(os.open(name, NEW_FILE_FLAGS, 0o666, dir_fd=self._folder), "wb")

    def _put(self, temporary: str, name: str) -> None:
        os.replace(temporary, name, src_dir_fd=self._folder, dst_dir_fd=self._folder)
        os.fsync(self._folder)

    def _gone(self) -> StickError:
        return StickError(
            Message("the USB stick at {path} was replaced by another one", path=self._volume.path),
        )

    def _no_folder(self) -> StickError:
        return StickError(
            Message(
                "{folder} on the USB stick {name} is a link, a file or another disk, not a folder "
                "of the stick; rename it",
                folder=self._name,
                name=self._volume.name,
            ),
        )

    def _differs(self, name: str) -> StickError:
        return StickError(
            Message(
                "the USB stick {name} does not hold what was written to {file}; do not rely on it",
                name=self._volume.name,
                file=name,
            ),
        )


def _sync(stream: IO[bytes]) -> None:
    stream.flush()
    os.fsync(stream.fileno())
