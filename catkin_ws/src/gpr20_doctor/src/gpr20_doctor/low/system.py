"""Memory of a computer, and the processes of ROS on it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Tuple

DEFAULT_PORT = 11311
BYTES_PER_KB, IPV4_BYTES = 1024, 4


class Memory(NamedTuple):
    """Memory of a computer: what programs may still have [bytes], and how often it ran out."""

    available_bytes: int
    ended_programs: int


def memory(root: Path) -> Memory:
    """Return what Linux says of the memory.

    Raises:
        OSError: It cannot be read.
        ValueError: It was not understood.
    """
    sizes = _numbers(root / "proc/meminfo")
    if "MemAvailable" not in sizes:
        raise ValueError("no MemAvailable in /proc/meminfo")
    counts = _numbers(root / "proc/vmstat")
    return Memory(sizes["MemAvailable"] * BYTES_PER_KB, counts.get("oom_kill", 0))


def _numbers(path: Path) -> Dict[str, int]:
    rows = (line.replace(":", " ").split() for line in path.read_text().splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) > 1}


class RosProcesses(NamedTuple):
    """What runs on a computer, also what nobody can ask; a master that is not known is "".

    Attributes:
        ports: Of the ROS masters.
        masters: The master of each node.
        configurations: (master, folder) of each launch with a folder of its own.
    """

    ports: List[int]
    masters: List[str]
    configurations: List[Tuple[str, Path]]

    def configuration(self, master: str) -> Optional[Path]:
        """Return the folder with which the robot of a master was launched; None: not known."""
        found = {folder for uri, folder in self.configurations if uri == master.rstrip("/")}
        return found.pop() if len(found) == 1 else None


def ros_processes(root: Path) -> RosProcesses:
    """Return the ROS masters, nodes and launches on this computer."""
    found = RosProcesses([], [], [])
    for process in (root / "proc").glob("[0-9]*"):
        words = _words(process / "cmdline")
        if _runs(words, "rosmaster") and "-p" in words[:-1]:
            port = words[words.index("-p") + 1]
            found.ports.append(int(port) if port.isdigit() else DEFAULT_PORT)
        # roslaunch names each node that it starts.
        is_node = any(one.startswith("__name:=") for one in words)
        if is_node or _runs(words, "roslaunch"):
            environment = _words(process / "environ")
            master = _after("ROS_MASTER_URI=", environment).rstrip("/")
            folder = _after("config:=", words) or _after("GPR20_CONFIG=", environment)
            if is_node:
                found.masters.append(master)
            elif folder:
                path = Path(os.path.realpath(str(process / "cwd"))) / Path(folder).expanduser()
                found.configurations.append((master, path))
    return found


def _runs(words: List[str], program: str) -> bool:
    return any(Path(word).name == program for word in words[:3])


def _after(prefix: str, words: List[str]) -> str:
    return next((one[len(prefix) :] for one in words if one.startswith(prefix)), "")


def _words(path: Path) -> List[str]:
    try:
        return path.read_bytes().decode(errors="replace").split("\0")
    except OSError:
        return []  # it has just ended, or belongs to somebody else


def listening(root: Path) -> List[Tuple[str, int]]:
    """Return (IPv4 address, port) of everything that listens by TCP, whatever its process.

    Raises:
        OSError: That cannot be read.
        ValueError: It was not understood.
    """
    found = []
    # A kernel without IPv6 has no second table.
    more = [one for one in [root / "proc/net/tcp6"] if one.exists()]
    for table in (root / "proc/net/tcp", *more):
        lines = table.read_text().splitlines()[1:]
        for address, port in (line.split()[1].split(":") for line in lines if _listens(line)):
            numbers = bytes.fromhex(address)
            if len(numbers) == IPV4_BYTES or not any(numbers):
                first = reversed(numbers[:IPV4_BYTES])
                found.append((".".join(map(str, first)), int(port, 16)))
    return found


def _listens(line: str) -> bool:
    return line.split()[3] == "0A"
