"""Memory and disk of a computer, and what of ROS runs and listens on it."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Tuple
from urllib.parse import urlsplit

from gpr20_doctor.low.network import addresses_of, is_own_address

DEFAULT_PORT = 11311
BYTES_PER_KB, IPV4_BYTES = 1024, 4
# As a survey: one JSON file and two recordings.
FILES = 3
TRACES = 4
ENOUGH_S = 2.0
LAUNCHES = ("roslaunch", "roscore", "rostest")


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


class RosNode(NamedTuple):
    """A process that is a node of ROS.

    Attributes:
        number: Its process id.
        master: Its master; empty: not known.
        address: Where it listens, as ROS_HOSTNAME or ROS_IP says; empty: not known.
        left_over: Whether the roslaunch that has started it has ended.
        launch: Name of the configuration of its launch; empty: none.
        watches: State of the process (proc(5)) if it is the watchdog of the launch; else empty.
    """

    number: int
    master: str
    address: str
    left_over: bool
    launch: str = ""
    watches: str = ""


class RosProcesses(NamedTuple):
    """What runs on a computer, also what nobody can ask.

    Attributes:
        ports: Of the ROS masters.
        nodes: All nodes.
        configurations: (master, folder) of each launch with a folder of its own.
    """

    ports: List[int]
    nodes: List[RosNode]
    configurations: List[Tuple[str, Path]]

    def nodes_of(self, master: str) -> List[RosNode]:
        """Return the nodes of a master, and those whose master is not known.

        roslaunch calls a master of this computer by an address that may be gone.
        """
        wanted = urlsplit(plain_uri(master))
        here = any(map(is_own_address, addresses_of(wanted.hostname or "")))
        known = {"", wanted.geturl()}
        known |= {one.master for one in self.nodes if here and _port(one.master) == wanted.port}
        return [one for one in self.nodes if one.master in known]

    def configuration(self, master: str) -> Optional[Path]:
        """Return the folder with which the robot of a master was launched; None: not known."""
        found = {folder for uri, folder in self.configurations if uri == plain_uri(master)}
        return found.pop() if len(found) == 1 else None


def _port(master: str) -> Optional[int]:
    try:
        return urlsplit(master).port
    except ValueError:
        return None


def plain_uri(master: str) -> str:
    """Return the address of a master as it is compared."""
    return master.rstrip("/").replace("//127.0.0.1:", "//localhost:")


def ros_processes(root: Path) -> RosProcesses:
    """Return the ROS masters, nodes and launches on this computer."""
    found = RosProcesses([], [], [])
    for process in (root / "proc").glob("[0-9]*"):
        words = _words(process / "cmdline")
        if _runs(words, "rosmaster") and "-p" in words[:-1]:
            port = words[words.index("-p") + 1]
            found.ports.append(int(port) if port.isdigit() else DEFAULT_PORT)
        # roslaunch gives each node that it starts a name, and the file of its log.
        is_node = _after("__name:=", words)
        if is_node or _runs(words, "roslaunch"):
            environment = _words(process / "environ")
            master = plain_uri(_after("ROS_MASTER_URI=", environment))
            folder = _after("config:=", words) or _after("GPR20_CONFIG=", environment)
            if is_node:
                address = _after("ROS_HOSTNAME=", environment) or _after("ROS_IP=", environment)
                left_over = bool(_after("__log:=", words)) and not _has_launch(process)
                launch = _after("configuration:=", words) or _after("--launch=", words)
                status = "".join(_words(process / "stat")) if _after("--launch=", words) else ""
                watches = status.rpartition(") ")[2][:1]
                one = RosNode(int(process.name), master, address, left_over, launch, watches)
                found.nodes.append(one)
            elif folder:
                with contextlib.suppress(OSError):  # where another user is, nobody else may see
                    found.configurations.append((master, _seen_from(process, folder)))
    return found


def _seen_from(process: Path, folder: str) -> Path:
    path = Path(folder).expanduser()
    return path if path.is_absolute() else Path(os.readlink(str(process / "cwd"))) / path


def _has_launch(process: Path) -> bool:
    """Return whether a roslaunch is above a process; True where that cannot be read."""
    while not _runs(_words(process / "cmdline"), *LAUNCHES):
        if process.name in ("0", "1"):
            return False
        try:
            status = (process / "stat").read_text(errors="replace")
        except OSError:
            return True  # it has just ended
        # After the name, which is in brackets and may hold blanks, and the state.
        process = process.with_name(status[status.rindex(")") + 2 :].split()[1])
    return True


def _runs(words: List[str], *programs: str) -> bool:
    return any(Path(word).name in programs for word in words[:3])


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


def slowest_trace_s(folder: Path, trace_bytes: int) -> float:
    """Return how long the slowest of some traces took [s], each flushed to the disk.

    The files have no names, so nothing is left of them however this process ends.

    Args:
        folder: On the disk.
        trace_bytes: Size of one trace in all files together.

    Raises:
        OSError: The disk refused.
    """
    # Random, so that a disk that compresses does not gain from it.
    part = os.urandom(trace_bytes // FILES)
    slowest_s = 0.0
    first_s = time.monotonic()
    for _trace in range(TRACES):
        begin_s = time.monotonic()
        for _file in range(FILES):
            with tempfile.TemporaryFile(dir=folder, prefix=".gpr20-", suffix=".tmp") as file:
                file.write(part)
                file.flush()
                os.fsync(file.fileno())
        slowest_s = max(slowest_s, time.monotonic() - begin_s)
        if time.monotonic() - first_s > ENOUGH_S:
            break
    return slowest_s
