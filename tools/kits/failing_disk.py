"""Disks that fail, or lose their power, at any call; what is durable is known.

`PowerCutDisk` is a file system, ext4 in a file, shut down without flushing its log. A cut loses
what a program gave to the kernel without waiting for fsync. It needs root, the program mkfs.ext4
and a loop device.
"""

from __future__ import annotations

import _pyio
import builtins
import contextlib
import ctypes
import errno
import fcntl
import io
import os
import random
import stat
import struct
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Callable, Dict, Optional, Sequence
from unittest import mock

CALLS = ("pwrite", "fsync", "ftruncate", "link", "unlink", "replace", "mkdir")
MORE_CALLS = (*CALLS, "open", "write", "fdatasync", "rename")
SECTOR_BYTES = 512
FOR_EVER = 1 << 30


@dataclass(frozen=True)
class Failure:
    """What happens to the disk within a request, or behind it if the request needs fewer calls.

    Attributes:
        calls: How many calls of the disk still succeed.
        power: Whether its power is cut and the process gone; else its calls fail.
        lost_share: How much of what was not made durable is lost; nothing is, where only the
            process ends.
        seed: Of what is lost.
        by_sector: Whether each sector of a file is lost or kept for itself.
        error: With which errno calls fail.
        lasts: How many calls fail.
        short: Whether the first half of what is to be written is written before the failure.
    """

    calls: int
    power: bool
    lost_share: float = 1.0
    seed: int = 0
    by_sector: bool = False
    error: int = errno.ENOSPC
    lasts: int = FOR_EVER
    short: bool = False


class FailingDisk:
    """Stands between this process and the disk, until it is released.

    Args:
        place: The folder that is on this disk.
        calls: The functions of `os` that are its calls.
        on_cut: Called after the power was cut, when what is left was written.
    """

    def __init__(
        self,
        place: Path,
        calls: Sequence[str] = CALLS,
        on_cut: Callable[[], None] = lambda: None,
    ) -> None:
        self._patches = contextlib.ExitStack()
        self._failure: Optional[Failure] = None
        self._left = self._failed = 0
        self.has_failed = False
        self.folder, self._after_cut, self._on_cut = place, place, on_cut
        self._names: Dict[int, Dict[str, int]] = {}
        self._contents: Dict[int, bytes] = {}
        self._open: Dict[int, BinaryIO] = {}
        # All that is there is durable.
        for path in [place, *place.rglob("*")]:
            descriptor = os.open(str(path), os.O_RDONLY)
            self._note_durable(descriptor)
            os.close(descriptor)
        for name in calls:
            new = self._passing_on(name, getattr(os, name))
            self._patches.enter_context(mock.patch.object(os, name, new))
        if "write" in calls:
            # Python's own files call the kernel past `os`; those written in Python do not.
            for module in (builtins, io):
                self._patches.enter_context(mock.patch.object(module, "open", _pyio.open))

    def release(self) -> None:
        """Let the calls go to the disk itself."""
        self._patches.close()
        for stream in self._open.values():
            stream.close()

    def begin(self, failure: Optional[Failure], after_cut: Path) -> None:
        """Fail in the middle of what is done from now on.

        Args:
            failure: What fails; None: nothing does.
            after_cut: Where what a power cut leaves is put.
        """
        self.has_failed, self._after_cut, self._failed = False, after_cut, 0
        self._left = failure.calls if failure else 0
        self._failure = failure

    def end(self) -> None:
        """Fail no more; a power cut that has not come yet comes now."""
        failure, self._failure = self._failure, None
        if failure is not None and failure.power and not self.has_failed:
            self._cut(failure)

    def _passing_on(self, name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            failure = self._failure
            if failure is not None and self._meets(failure, name, arguments):
                if self._left > 0:
                    self._left -= 1
                else:
                    self._fail(failure, name, real, arguments)
            result = real(*arguments, **options)
            if name in ("fsync", "fdatasync"):
                self._note_durable(arguments[0])
            return result

        return call

    def _meets(self, failure: Failure, name: str, arguments: Sequence[Any]) -> bool:
        # A disk that is full or read-only can be read.
        reads = name == "open" and not arguments[1] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        if reads and failure.error != errno.EIO:
            return False
        place = arguments[0]
        if isinstance(place, int):
            with contextlib.suppress(OSError):
                place = os.readlink(f"/proc/self/fd/{place}")
        path = os.fsdecode(place) if not isinstance(place, int) else ""
        return path == str(self.folder) or path.startswith(f"{self.folder}/")

    def _fail(
        self, failure: Failure, name: str, real: Callable[..., Any], arguments: Sequence[Any]
    ) -> None:
        if not failure.power:
            if self._failed == failure.lasts:
                return
            self.has_failed = True
            self._failed += 1
            if failure.short and self._failed == 1:
                _write_half(name, real, arguments)
            if name != "unlink" or failure.error != errno.ENOSPC:  # which makes space
                raise OSError(failure.error, os.strerror(failure.error))
            return
        if not self.has_failed:
            _write_half(name, real, arguments)
            self._failure = None
            self._cut(failure)
            self._failure = failure
        raise OSError(errno.EIO, "the power is off")

    def _note_durable(self, descriptor: int) -> None:
        status = os.fstat(descriptor)
        if stat.S_ISDIR(status.st_mode):
            self._names[status.st_ino] = _names_in(descriptor)
            return
        if status.st_ino not in self._open:
            # While a file is open, no other one gets its number.
            self._open[status.st_ino] = open(f"/proc/self/fd/{descriptor}", "rb")  # noqa: SIM115
        self._contents[status.st_ino] = self._read(status.st_ino)

    def _read(self, number: int) -> bytes:
        stream = self._open[number]
        return os.pread(stream.fileno(), os.fstat(stream.fileno()).st_size, 0)

    def _cut(self, failure: Failure) -> None:
        """Write what the disk holds after a power cut: each thing as it is now, or was durable."""
        self.has_failed = True
        draw = random.Random(failure.seed)
        paths = {path.lstat().st_ino: path for path in [self.folder, *self.folder.rglob("*")]}

        def restore(number: int, target: Path) -> None:
            is_lost = draw.random() < failure.lost_share
            if number in self._names or (number in paths and paths[number].is_dir()):
                durable = self._names.get(number, {})
                target.mkdir(parents=True)
                for name, inner in sorted(
                    (durable if is_lost else _names_in(paths[number])).items()
                ):
                    restore(inner, target / name)
                return
            before, now = self._contents.get(number, b""), self._content_now(number, paths)
            if failure.by_sector:
                target.write_bytes(_torn(before, now, draw, failure.lost_share))
            else:
                target.write_bytes(before if is_lost else now)

        restore(self.folder.stat().st_ino, self._after_cut)
        self._on_cut()

    def _content_now(self, number: int, paths: Dict[int, Path]) -> bytes:
        if number in self._open:
            return self._read(number)
        return paths[number].read_bytes() if number in paths else b""


def _names_in(folder: Any) -> Dict[str, int]:
    """Return the names in a folder (path or descriptor), with the numbers of the files."""
    with os.scandir(folder) as entries:
        return {one.name: one.inode() for one in entries}


def _write_half(name: str, real: Callable[..., Any], arguments: Sequence[Any]) -> None:
    if name in ("pwrite", "write"):
        descriptor, data, *offset = arguments
        real(descriptor, bytes(data)[: len(data) // 2], *offset)


def _torn(before: bytes, now: bytes, draw: random.Random, lost_share: float) -> bytes:
    """Return a file in which each sector is that of before or that of now, and so is its size."""
    size = len(before if draw.random() < lost_share else now)
    content = bytearray()
    for start in range(0, size, SECTOR_BYTES):
        source = before if draw.random() < lost_share else now
        length = min(SECTOR_BYTES, size - start)
        content += source[start : start + length].ljust(length, b"\0")
    return bytes(content)


UNMOUNT_LIMIT_S = 10.0
# <linux/sched.h> and <linux/ext4.h>; the number of the call is _IOR('X', 125, __u32).
CLONE_NEWNS = 0x00020000
EXT4_IOC_SHUTDOWN = 0x8004587D
EXT4_GOING_FLAGS_NOLOGFLUSH = 2


class PowerCutError(Exception):
    """This machine does not let a file system be mounted or shut down."""


class PowerCutDisk:
    """An empty file system, not mounted yet; each method raises a PowerCutError if it fails.

    Args:
        place: A folder for the file that holds it and for its mount point.
        size_mib: Its size [MiB]; the file is sparse.
    """

    def __init__(self, place: Path, size_mib: int = 256) -> None:
        self._image = place / "disk.img"
        self.folder = place / "disk"
        self.folder.mkdir()
        with self._image.open("xb") as file:
            file.truncate(size_mib << 20)
        # Made at once, not in the background later.
        at_once = "lazy_itable_init=0,lazy_journal_init=0"
        _run("mkfs.ext4", "-q", "-F", "-E", at_once, str(self._image))

    def mount(self) -> None:
        """Mount it; after a cut, what its journal holds is restored first."""
        # The system frees the loop device with the mount.
        _run("mount", "-t", "ext4", "-o", "loop", str(self._image), str(self.folder))

    def write_back(self) -> None:
        """Write everything to the disk, as the kernel does by itself now and then."""
        _run("sync", "-f", str(self.folder))

    def cut(self) -> None:
        """Cut the power: every call for the disk fails until it was unmounted and mounted."""
        flags = struct.pack("I", EXT4_GOING_FLAGS_NOLOGFLUSH)
        descriptor = os.open(str(self.folder), os.O_RDONLY | os.O_CLOEXEC)
        try:
            fcntl.ioctl(descriptor, EXT4_IOC_SHUTDOWN, flags)
        except OSError as error:
            raise PowerCutError(f"ext4 cannot be shut down: {error}") from error
        finally:
            os.close(descriptor)

    def unmount(self) -> None:
        """Unmount it, when the processes that used it and were killed have let go of it."""
        deadline_s = time.monotonic() + UNMOUNT_LIMIT_S
        while True:
            try:
                return _run("umount", str(self.folder))
            except PowerCutError:
                if time.monotonic() > deadline_s:
                    raise
            time.sleep(0.02)


def can_be_cut() -> None:
    """Cut the power of a file system once.

    What this process mounts from now on is seen by it and its children only, and ends with the
    last of them, however it ends.

    Raises:
        PowerCutError: It cannot be done here.
    """
    if ctypes.CDLL(None, use_errno=True).unshare(CLONE_NEWNS) != 0:
        reason = os.strerror(ctypes.get_errno())
        raise PowerCutError(f"a mount namespace needs root: {reason}")
    _run("mount", "--make-rprivate", "/")
    with tempfile.TemporaryDirectory(prefix="gpr20_power_cut_") as place:
        disk = PowerCutDisk(Path(place))
        disk.mount()
        try:
            disk.cut()
        finally:
            disk.unmount()


def _run(*command: str) -> None:
    try:
        subprocess.run(command, capture_output=True, text=True, check=True)
    except OSError as error:
        raise PowerCutError(f"{command[0]} cannot be run: {error.strerror}") from error
    except subprocess.CalledProcessError as error:
        # Without the hint to read the kernel's log.
        raise PowerCutError(f"{command}: {error.stderr.strip().partition(chr(10))[0]}") from error
