"""A file system whose power can be cut: ext4 in a file, shut down without flushing its log.

A cut loses what a program gave to the kernel without waiting for fsync. Needs root, the program
mkfs.ext4 and a loop device.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import struct
import subprocess
import tempfile
import time
from pathlib import Path

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
