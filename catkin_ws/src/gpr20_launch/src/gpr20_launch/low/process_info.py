"""Processes of this computer, as /proc shows them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Optional, Tuple

PROC = Path("/proc")
# After the name, which is in brackets and may hold blanks (proc(5)).
_PARENT, _START_TIME = 1, 19


@dataclass(frozen=True)
class ProcessInfo:
    """One process.

    Attributes:
        number: Its process id.
        parent: Process id of its parent.
        command: The words of its command line.
        started: When it was started, local time.
    """

    number: int
    parent: int
    command: Tuple[str, ...]
    started: datetime

    @property
    def is_roslaunch(self) -> bool:
        """Whether it is roslaunch, which `roscore` is too."""
        names = {Path(word).name for word in self.command[:3]}
        return bool(names & {"roslaunch", "roscore", "rostest"})

    def may_be_node(self, name: str) -> bool:
        """Whether it can be the node with this full name.

        roslaunch gives the name in the command line; rosrun starts the program of the same name.
        """
        base = name.rsplit("/", 1)[-1]
        programs = [Path(word).name for word in self.command[:2]]
        return f"__name:={base}" in self.command or any(one.endswith(base) for one in programs)


def process_info(number: int) -> Optional[ProcessInfo]:
    """Return what is known about a process; None if there is none on this computer."""
    try:
        status = (PROC / str(number) / "stat").read_text(errors="replace")
        command = (PROC / str(number) / "cmdline").read_bytes()
        up_since_s = _boot_time_s()
    except OSError:
        return None
    fields = status[status.rindex(")") + 2 :].split()
    started_s = up_since_s + int(fields[_START_TIME]) / os.sysconf("SC_CLK_TCK")
    words = tuple(os.fsdecode(word) for word in command.split(b"\0") if word)
    return ProcessInfo(number, int(fields[_PARENT]), words, datetime.fromtimestamp(started_s))


def _boot_time_s() -> int:
    for line in (PROC / "stat").read_text().splitlines():
        if line.startswith("btime "):
            return int(line.split()[1])
    raise OSError("/proc/stat has no boot time")
