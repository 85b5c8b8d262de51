"""Checks of the disks that are written to: of the surveys, the system, the logs, the state.

Whether the folder of the surveys is the right one, the check of the configuration says.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Iterator

from gpr20_common.faults import DISK_FULL, DISK_REFUSES
from gpr20_common.low.data_folder import state_folder
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import Machine
from gpr20_survey.folder.data_folder import existing_folder, file_system_of

MB, GB = 1e6, 1e9
# Of the disk of the surveys, and of the others, which take the logs of a day [bytes]; below the
# second of each, programs fail when they write.
DATA_SPACE, OTHER_SPACE = (5 * GB, 0.5 * GB), (200 * MB, 20 * MB)
FEW_FILES = 2000


def check_volumes(machine: Machine) -> Iterator[Finding]:
    """Judge each file system that the robot writes to, once, and whether this user may write."""
    own = list(filter(None, (machine.data, machine.log, state_folder(machine.environment))))
    devices = set()
    for folder in (*own, machine.root, machine.root / "tmp", machine.root / "var/log"):
        existing = existing_folder(folder)
        device, allowed = existing.stat().st_dev, os.access(str(existing), os.W_OK)
        refused = folder in own and not allowed and not file_system_of(existing).read_only
        if refused:
            yield _refused(printable(existing))
        elif device not in devices:
            is_data = folder == machine.data
            check, limits = ("data_disk", DATA_SPACE) if is_data else ("volumes", OTHER_SPACE)
            yield _volume(check, folder, existing, *limits)
        devices.add(device)


def _refused(folder: str) -> Finding:
    text = Message("This user may not write into {folder}.", folder=folder)
    advice = Message(
        'If the robot runs as this user, run: sudo chown "$USER" {folder}. If it has '
        "services, run: gpr20-run doctor",
        folder=folder,
    )
    return Finding.of("volumes", text, DISK_REFUSES, mild=True, advice=advice)


def _volume(check: str, folder: Path, existing: Path, low: float, none: float) -> Finding:
    system, numbers = file_system_of(existing), os.statvfs(str(existing))
    free, files = numbers.f_bavail * numbers.f_frsize, numbers.f_favail
    names = {"point": printable(system.mount_point), "folder": printable(folder)}
    if system.read_only:
        text = Message("The file system {point} is read-only; {folder} is on it.", **names)
        advice = Message(
            "Copy what must not be lost from {point}. Then run: sudo mount -o remount,rw {point}. "
            "If that fails or it happens again, replace the card or disk.",
            **names,
        )
        return Finding.of(check, text, DISK_REFUSES, advice=advice)
    text = Message(
        "The file system {point} has {free_mb:.0f} MB left; {folder} is on it.",
        free_mb=free / MB,
        **names,
    )
    full, mild = free < low, free >= none
    if not full and numbers.f_files and files < FEW_FILES:
        text = Message(
            "The file system {point} can hold only {count} more files; {folder} is on it.",
            count=files,
            **names,
        )
        full, mild = True, False
    advice = Message(
        "Make space on {point}, but copy surveys before you delete them. To see what is large, "
        "run: sudo du -xh {point} | sort -h | tail",
        **names,
    )
    return Finding.of(check, text, DISK_FULL if full else None, mild, advice)
