"""Memory of a computer, and the processes of ROS on it."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List, NamedTuple, Tuple

DEFAULT_PORT = 11311
BYTES_PER_KB = 1024


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
    """What runs on a computer: ports of ROS masters, and the master of each node; "": unknown."""

    ports: List[int]
    masters: List[str]


def ros_processes(root: Path) -> RosProcesses:
    """Return the ROS masters and nodes on this computer, also those that nobody can ask."""
    found = RosProcesses([], [])
    for folder in (root / "proc").glob("[0-9]*"):
        words = _words(folder / "cmdline")
        if any(word.endswith("/rosmaster") for word in words[:3]) and "-p" in words[:-1]:
            port = words[words.index("-p") + 1]
            found.ports.append(int(port) if port.isdigit() else DEFAULT_PORT)
        # roslaunch names each node that it starts.
        if any(one.startswith("__name:=") for one in words):
            prefix = "ROS_MASTER_URI="
            own = (one for one in _words(folder / "environ") if one.startswith(prefix))
            found.masters.append(next(own, prefix)[len(prefix) :].rstrip("/"))
    return found


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
    for line in (root / "proc/net/tcp").read_text().splitlines()[1:]:
        _number, local, _remote, state = line.split()[:4]
        if state == "0A":
            address, port = local.split(":")
            found.append((".".join(map(str, reversed(bytes.fromhex(address)))), int(port, 16)))
    return found
