"""The USB sticks that are mounted on this computer, by lsblk."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Tuple

from gpr20_common.faults import NOT_SET_UP
from gpr20_common.message import Message
from gpr20_imaging import faults
from gpr20_imaging.errors import ImagingError
from gpr20_survey.results.volume import Volume

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
        raise ImagingError(
            Message(
                "the USB stick at {path} is not mounted any more; plug it in",
                path=repr(path[:200]),
            ),
            fault=faults.STICK,
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
