"""The nodes that the roslaunch of this process has started, as /proc shows them."""

from __future__ import annotations

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
            os.kill(number, signal.SIGKILL)

    def _name(self, number: int) -> Optional[str]:
        try:
            if _parent(number) != self._parent:
                return None
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
    lines = (PROC / str(number) / "status").read_text(errors="replace").splitlines()
    return any(line.startswith("TracerPid:") and line.split()[1] != "0" for line in lines)


def is_working(number: int) -> bool:
    """Return whether a thread of the process runs, waits for a processor, or for a disk."""
    tasks = (PROC / str(number) / "task").glob("*/stat")
    return any(_fields(path)[0] in WORKING for path in tasks)


def _parent(number: int) -> int:
    return int(_fields(PROC / str(number) / "stat")[1])


def _fields(path: Path) -> List[str]:
    text = path.read_text(errors="replace")
    # The name, in brackets, may hold blanks.
    return text[text.rindex(")") + 2 :].split()


def _strings(number: int, file: str) -> List[str]:
    content = (PROC / str(number) / file).read_bytes()
    return [os.fsdecode(one) for one in content.split(b"\0") if one]
