"""What runs on a computer, also what nobody can ask: ROS masters, launches and nodes."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Tuple
from urllib.parse import urlsplit

from gpr20_doctor.low.network import is_here

DEFAULT_MASTER = "http://localhost:11311"
LAUNCHES = ("roslaunch", "roscore", "rostest")
# States of a process that does nothing (proc(5)): stopped, traced, ended.
HALTED = frozenset("TtZX")
# Of the words after the name, which is in brackets and may hold blanks (proc(5)).
STATE, PARENT, START = 0, 1, 19


class Process(NamedTuple):
    """A process.

    Attributes:
        number: Its process id.
        words: Of its command line.
        variables: Its environment; none where it belongs to somebody else.
        state: Such as S, or T if it was stopped.
        parent: Process id of its parent.
        started_s: When it was started, in seconds since 1970.
    """

    number: int
    words: Tuple[str, ...]
    variables: Tuple[str, ...]
    state: str
    parent: int
    started_s: float

    def argument(self, prefix: str) -> str:
        """Return what follows a prefix in the first word that has it; empty: none has."""
        return _after(prefix, self.words)

    def variable(self, *names: str) -> str:
        """Return the first of some variables that is set."""
        return next(filter(None, (_after(f"{one}=", self.variables) for one in names)), "")

    def runs(self, *programs: str) -> bool:
        """Return whether it is one of some programs, with or without an interpreter."""
        return any(Path(word).name in programs for word in self.words[:3])

    @property
    def node(self) -> str:
        """The name that roslaunch gave it, without its namespace; empty: it is no node."""
        return self.argument("__name:=")

    @property
    def master(self) -> str:
        """Address of its ROS master; empty: not known."""
        return plain_uri(self.variable("ROS_MASTER_URI"))


class Processes:
    """The processes of a computer, as they were when this was made."""

    def __init__(self, root: Path) -> None:
        """Read them; what ends meanwhile is left out.

        Args:
            root: Root of the file system.
        """
        self._root = root
        found = filter(None, map(_process, (root / "proc").glob("[0-9]*")))
        self._all: Dict[int, Process] = {one.number: one for one in found}

    @property
    def nodes(self) -> List[Process]:
        """All nodes that a roslaunch has started."""
        return [one for one in self._all.values() if one.node]

    def lacks_master(self, uri: str) -> bool:
        """Return whether an address is one of this computer, and no ROS master runs for it."""
        wanted = urlsplit(uri)
        return is_here(wanted.hostname or "") and not any(
            one.runs("rosmaster") and str(wanted.port) in one.words for one in self._all.values()
        )

    def nodes_of(self, master: str) -> List[Process]:
        """Return the nodes of a master, and those whose master is not known.

        roslaunch calls a master of this computer by an address that may be gone.
        """
        wanted, known = urlsplit(plain_uri(master)), {"", plain_uri(master)}
        if is_here(wanted.hostname or ""):
            end = f":{wanted.port}"
            known |= {one.master for one in self.nodes if one.master.endswith(end)}
        return [one for one in self.nodes if one.master in known]

    def launches_of(self, master: str) -> List[Process]:
        """Return the launches above the nodes of a master."""
        found = map(self.launch_of, self.nodes_of(master))
        return list({one.number: one for one in found if one is not None}.values())

    def launch_of(self, process: Process) -> Optional[Process]:
        """Return the roslaunch above a process; None: there is none, or it is not known."""
        above: Optional[Process] = process
        while above is not None and not above.runs(*LAUNCHES):
            above = self._all.get(above.parent)
        return above

    def is_left_over(self, process: Process) -> bool:
        """Return whether the roslaunch that has started a node has ended."""
        return bool(process.argument("__log:=")) and self.launch_of(process) is None

    def configuration(self, master: str) -> Optional[Path]:
        """Return the folder with which the robot of a master was launched; None: not known."""
        found = set()
        for one in self._all.values():
            folder = one.argument("config:=") or one.variable("GPR20_CONFIG")
            if folder and one.runs("roslaunch") and one.master == plain_uri(master):
                with contextlib.suppress(OSError):  # where another user is, nobody else may see
                    working = os.readlink(str(self._root / f"proc/{one.number}/cwd"))
                    found.add(Path(working) / Path(folder).expanduser())
        return found.pop() if len(found) == 1 else None


def plain_uri(master: str) -> str:
    """Return the address of a master as it is compared."""
    return master.rstrip("/").replace("//127.0.0.1:", "//localhost:")


def _process(folder: Path) -> Optional[Process]:
    try:
        status = (folder / "stat").read_text(errors="replace")
        boot_s = int((folder.parent / "stat").read_text().partition("btime ")[2].split()[0])
    except OSError:
        return None  # it has just ended
    fields = status[status.rindex(")") + 2 :].split()
    started_s = boot_s + int(fields[START]) / os.sysconf("SC_CLK_TCK")
    words, variables = _words(folder / "cmdline"), _words(folder / "environ")
    number, parent = int(folder.name), int(fields[PARENT])
    return Process(number, words, variables, fields[STATE], parent, started_s)


def _after(prefix: str, words: Tuple[str, ...]) -> str:
    return next((one[len(prefix) :] for one in words if one.startswith(prefix)), "")


def _words(path: Path) -> Tuple[str, ...]:
    try:
        return tuple(path.read_bytes().decode(errors="replace").split("\0"))
    except OSError:
        return ()  # it has just ended, or belongs to somebody else
