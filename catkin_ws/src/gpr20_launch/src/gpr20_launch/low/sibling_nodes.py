"""The nodes that the roslaunch of this process has started, as /proc shows them."""

from __future__ import annotations

import contextlib
import glob
import os
import signal
from pathlib import Path
from typing import Collection, Dict, List, Optional

PROC = Path("/proc")
NAME_WORD = "__name:="
# States of a thread that uses the processor, waits for it, or waits for a disk (proc(5)).
WORKING = frozenset("RD")


class SiblingNodes:
    """The nodes beside this process: children of the same roslaunch on this computer."""

    def __init__(self, parent: int, word: str, others: Collection[str]) -> None:
        """Look at nothing yet.

        Args:
            parent: Process id of the roslaunch.
            word: A node is one of ours if its command line has this word,
            others: or if its full name is one of these.
        """
        self._parent = parent
        self._word = word
        self._others = frozenset(others)

    def find(self) -> Dict[int, str]:
        """Return the full name of each node, by its process id."""
        numbers = [int(path.name) for path in PROC.iterdir() if path.name.isdigit()]
        names = {number: self._name(number) for number in numbers if number != os.getpid()}
        return {number: name for number, name in names.items() if name is not None}

    def kill(self, number: int, name: str) -> None:
        """End the process, if it is still that of the node."""
        if self._name(number) == name:
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.kill(number, signal.SIGKILL)

    def _name(self, number: int) -> Optional[str]:
        if _fields(PROC / str(number) / "stat")[1:2] != [str(self._parent)]:
            return None
        try:
            words = _strings(number, "cmdline")
            variables = _strings(number, "environ")
        except OSError:
            return None  # it has ended
        base = next((word[len(NAME_WORD) :] for word in words if word.startswith(NAME_WORD)), "")
        prefix = next((one for one in variables if one.startswith("ROS_NAMESPACE=")), "=/")
        name = f"/{prefix.partition('=')[2].strip('/')}/{base}".replace("//", "/")
        return name if base and (self._word in words or name in self._others) else None


def is_traced(number: int) -> bool:
    """Return whether a debugger has halted the process, or could."""
    lines = _text(PROC / str(number) / "status").splitlines()
    return any(line.startswith("TracerPid:") and line.split()[1] != "0" for line in lines)


def is_working(number: int) -> bool:
    """Return whether a thread of the process runs, waits for a processor, or for a disk."""
    tasks = glob.glob(str(PROC / str(number) / "task/*/stat"))
    return any(WORKING.intersection(_fields(Path(one))[:1]) for one in tasks)


def _fields(path: Path) -> List[str]:
    # The name, in brackets, may hold blanks.
    return _text(path).rpartition(")")[2].split()


def _text(path: Path) -> str:
    try:
        return path.read_text(errors="replace")
    except OSError:
        return ""  # the process or the thread has just ended


def _strings(number: int, file: str) -> List[str]:
    content = (PROC / str(number) / file).read_bytes()
    return [os.fsdecode(one) for one in content.split(b"\0") if one]
