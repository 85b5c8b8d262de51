"""What runs on a computer, also what nobody can ask, as /proc shows it (proc(5)); and asking it."""

from __future__ import annotations

import contextlib
import os
import subprocess
import threading
from concurrent.futures import Future, wait
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Callable, List, Optional, Sequence, Tuple, TypeVar
from urllib.parse import urlsplit

from gpr20_doctor.low.masters import is_here

DEFAULT_MASTER = "http://localhost:11311"
LAUNCHES = ("roslaunch", "roscore", "rostest")
PROC = Path("/proc")
# States of a process that does nothing: stopped, traced, ended.
HALTED = frozenset("TtZX")
# Of the words after the name, which is in brackets and may hold blanks.
STATE, PARENT, START = 0, 1, 19
# Of a program that has nothing to do but to say what it knows, on a busy computer.
ANSWER_LIMIT_S = 4.0
# What a check that fails raises.
FAILURES = (OSError, ValueError, LookupError)

Found = TypeVar("Found")


@dataclass(frozen=True)
class Process:
    """A process: its id, that of its parent, and the words of its command line.

    Attributes:
        state: Such as S, or T if it was stopped.
        start: When it was started, in ticks of the system since its start.
        folder: Where it is shown.
    """

    number: int
    parent: int
    words: Tuple[str, ...]
    state: str = "S"
    start: int = 0
    folder: Path = PROC / "0"

    @cached_property
    def variables(self) -> Tuple[str, ...]:
        """Its environment; none if it has ended, or belongs to somebody else."""
        return _words(self.folder / "environ")

    @property
    def started_s(self) -> float:
        """When it was started, in seconds since 1970."""
        text = (self.folder.parent / "stat").read_text()
        return int(text.partition("btime ")[2].split()[0]) + self.start / os.sysconf("SC_CLK_TCK")

    def argument(self, prefix: str) -> str:
        """Return what follows a prefix in the first word that has it; empty: none has."""
        return _after(prefix, self.words)

    def variable(self, *names: str) -> str:
        """Return the first of some variables that is set."""
        return next(filter(None, (_after(f"{one}=", self.variables) for one in names)), "")

    @property
    def is_launch(self) -> bool:
        """Whether it is roslaunch, with or without an interpreter; `roscore` is it, too."""
        return self.runs(*LAUNCHES)

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
        self._all = {one.number: one for one in all_processes(root / "proc")}

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
        while above is not None and not above.is_launch:
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
                    working = os.readlink(str(one.folder / "cwd"))
                    found.add(Path(working) / Path(folder).expanduser())
        return found.pop() if len(found) == 1 else None


def plain_uri(master: str) -> str:
    """Return the address of a master as it is compared."""
    return master.rstrip("/").replace("//127.0.0.1:", "//localhost:")


def all_processes(proc: Path = PROC) -> List[Process]:
    """Return the processes that run now."""
    found = (process_of(int(path.name), proc) for path in proc.glob("[0-9]*"))
    return [one for one in found if one is not None]


def process_of(number: int, proc: Path = PROC) -> Optional[Process]:
    """Return what is known about a process; None if there is none on this computer."""
    folder = proc / str(number)
    fields = _fields(folder / "stat")
    if not fields:
        return None
    words = _words(folder / "cmdline")
    return Process(number, int(fields[PARENT]), words, fields[STATE], int(fields[START]), folder)


def answer_of(
    command: Sequence[str],
    limit_s: float = ANSWER_LIMIT_S,
    statuses: Sequence[int] = (0,),
) -> str:
    """Return what a program prints.

    Args:
        command: The program and its arguments.
        limit_s: Within which it must end [s].
        statuses: Exit statuses of an answer.

    Raises:
        FileNotFoundError: It is not installed.
        OSError: It failed or was late.
    """
    try:
        ended = subprocess.run(
            command, capture_output=True, timeout=limit_s, text=True, errors="replace"
        )
    except subprocess.TimeoutExpired as error:
        raise TimeoutError(str(error)) from error
    if ended.returncode not in statuses:
        raise OSError(ended.stderr.strip() or f"{command[0]} ended with {ended.returncode}")
    return ended.stdout


def in_time(work: Callable[[], Found], limit_s: float) -> Found:
    """Return what some work finds that cannot be interrupted if it hangs, such as on a disk.

    Raises:
        TimeoutError: It took longer.
        OSError, ValueError, LookupError: The work raised it.
    """
    found: Future[Found] = Future()

    def run() -> None:
        try:
            found.set_result(work())
        except FAILURES as error:
            found.set_exception(error)

    # Nobody waits for it at the end of the program.
    threading.Thread(target=run, daemon=True).start()
    if not wait([found], limit_s).done:
        raise TimeoutError(f"no answer within {limit_s:g} s")
    return found.result()


def _fields(path: Path) -> List[str]:
    try:
        text = path.read_text(errors="replace")
    except OSError:
        return []  # the process or the thread has just ended
    return text.rpartition(")")[2].split()


def _after(prefix: str, words: Tuple[str, ...]) -> str:
    return next((one[len(prefix) :] for one in words if one.startswith(prefix)), "")


def _words(path: Path) -> Tuple[str, ...]:
    try:
        content = path.read_bytes()
    except OSError:
        return ()  # it has just ended, or belongs to somebody else
    return tuple(os.fsdecode(one) for one in content.split(b"\0") if one)
