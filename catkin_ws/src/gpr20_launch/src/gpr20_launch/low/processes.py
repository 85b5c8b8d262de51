"""Processes of this computer, as /proc shows them (proc(5))."""

from __future__ import annotations

import glob
import os
from dataclasses import dataclass
from pathlib import Path
from typing import List, Optional, Tuple

PROC = Path("/proc")
NAME_WORD = "__name:="
# States of a thread that uses the processor, waits for it, or waits for a disk.
WORKING = frozenset("RD")


@dataclass(frozen=True)
class Process:
    """One process: its id, that of its parent, and the words of its command line."""

    number: int
    parent: int
    command: Tuple[str, ...]

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
        return NAME_WORD + base in self.command or any(one.endswith(base) for one in programs)

    @property
    def node(self) -> str:
        """Full name of the node that roslaunch has started as this process; empty: none."""
        words = [one[len(NAME_WORD) :] for one in self.command if one.startswith(NAME_WORD)]
        variables = _strings(self.number, "environ")
        prefix = next((one for one in variables if one.startswith("ROS_NAMESPACE=")), "=/")
        name = f"/{prefix.partition('=')[2].strip('/')}/{''.join(words[:1])}"
        return name.replace("//", "/") if words else ""


def process_of(number: int) -> Optional[Process]:
    """Return what is known about a process; None if there is none on this computer."""
    fields = _fields(PROC / str(number) / "stat")
    return Process(number, int(fields[1]), _strings(number, "cmdline")) if fields else None


def is_working(number: int) -> bool:
    """Return whether a thread of the process runs, waits for a processor, or for a disk."""
    tasks = glob.glob(str(PROC / str(number) / "task/*/stat"))
    return any(WORKING.intersection(_fields(Path(one))[:1]) for one in tasks)


def _fields(path: Path) -> List[str]:
    try:
        text = path.read_text(errors="replace")
    except OSError:
        return []  # the process or the thread has just ended
    # The name, in brackets, may hold blanks.
    return text.rpartition(")")[2].split()


def _strings(number: int, file: str) -> Tuple[str, ...]:
    try:
        content = (PROC / str(number) / file).read_bytes()
    except OSError:
        return ()  # it has just ended, or belongs to somebody else
    return tuple(os.fsdecode(one) for one in content.split(b"\0") if one)
