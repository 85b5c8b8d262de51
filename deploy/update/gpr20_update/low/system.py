"""Programs, durable files and locks of the system."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Callable, Iterable, Iterator, Mapping, Optional, Tuple

from gpr20_update.errors import UpdateError

BLOCK_BYTES = 1 << 20
NOT_ENDED = -1
ROOT = (0, 0)
_POLL_S = 0.2


@dataclass(frozen=True)
class Ended:
    """How a program ended.

    Attributes:
        status: Its exit status; NOT_ENDED: it did not end in time and was killed.
        output: What it printed.
        complaints: What it printed on standard error.
    """

    status: int
    output: str
    complaints: str

    @property
    def last_lines(self) -> str:
        """The end of what it printed, for people."""
        lines = [one.strip() for one in f"{self.output}\n{self.complaints}".splitlines()]
        return shown("; ".join([one for one in lines if one][-4:]))


def run(
    *command: str, limit_s: float, more: Optional[Mapping[str, str]] = None, text: bytes = b""
) -> Ended:
    """Run a program to its end, in a session of its own: a terminal that is closed cannot end it.

    Args:
        *command: The program and its arguments.
        limit_s: How long it may take [s].
        more: Further variables of its environment.
        text: What it reads.

    Raises:
        UpdateError: It cannot be started.
    """
    environment = {**os.environ, "LC_ALL": "C.UTF-8", **(more or {})}
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment,
            start_new_session=True,
            cwd="/",
        )
    except OSError as error:
        raise UpdateError(f"{command[0]} cannot be run: {error.strerror}") from error
    try:
        output, complaints = process.communicate(text, timeout=limit_s)
        status = process.returncode
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        output, complaints = process.communicate()
        status = NOT_ENDED
    return Ended(status, output.decode("utf-8", "replace"), complaints.decode("utf-8", "replace"))


def shown(text: object) -> str:
    """Return a text from outside as one line that can neither fake nor control the terminal."""
    return "".join(
        one if one.isprintable() else one.encode("unicode_escape", "surrogatepass").decode("ascii")
        for one in str(text)
    )


def sync(path: Path) -> None:
    """Return when a file, or the names in a folder, are durable."""
    descriptor = os.open(str(path), os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def replace_file(
    path: Path, blocks: Iterable[bytes], mode: int = 0o600, owner: Tuple[int, int] = ROOT
) -> None:
    """Give a file new content in one step, or leave it as it was; return when it is durable.

    Args:
        path: The file.
        blocks: Its content.
        mode: Its rights.
        owner: Numbers of its user and group.
    """
    temporary = path.with_name(f".{path.name}.new")
    with contextlib.suppress(FileNotFoundError):
        temporary.unlink()
    # No link is followed. A FAT stick refuses to change rights and owner.
    descriptor = os.open(str(temporary), os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    with open(descriptor, "wb") as file:
        if owner != ROOT:
            os.fchown(descriptor, *owner)
        file.writelines(blocks)
        file.flush()
        os.fsync(descriptor)
    os.replace(str(temporary), str(path))
    sync(path.parent)


def replace_link(path: Path, target: str) -> None:
    """Let a symbolic link name something else in one step; return when that is durable."""
    temporary = path.with_name(f"{path.name}.new")
    with contextlib.suppress(FileNotFoundError):
        temporary.unlink()
    temporary.symlink_to(target)
    os.replace(str(temporary), str(path))
    sync(path.parent)


def remove(folder: Path) -> None:
    """Remove a folder with everything in it, if it is there."""
    if folder.exists():
        shutil.rmtree(str(folder))
        sync(folder.parent)


@contextlib.contextmanager
def only_one(path: Path) -> Iterator[None]:
    """Hold a lock that one process can hold.

    Raises:
        UpdateError: Another process holds it.
    """
    with path.open("ab") as file:
        if not _is_taken(file):
            raise UpdateError("another gpr20-update is running; wait for its end")
        yield


@contextlib.contextmanager
def lock_of_dpkg(folder: Path, limit_s: float, wait: Callable[[], None]) -> Iterator[None]:
    """Hold the lock that every program holds which calls dpkg; wait for another one.

    A dpkg whose caller was killed lives on and holds only its own lock.

    Args:
        folder: Of the locks.
        limit_s: How long to wait [s].
        wait: Called once if there is another one.

    Raises:
        UpdateError: Another one holds them for longer than that.
    """
    with (folder / "lock-frontend").open("ab") as frontend, (folder / "lock").open("ab") as own:
        deadline_s, has_waited = time.monotonic() + limit_s, False
        while not (_is_taken(frontend) and _is_taken(own)):
            if time.monotonic() > deadline_s:
                raise UpdateError(
                    f"another program has installed packages for {limit_s:.0f} s ({folder} is "
                    "locked); wait for its end and repeat, with gpr20-update --continue if "
                    "--status says UNFINISHED"
                )
            if not has_waited:
                wait()
            has_waited = True
            time.sleep(_POLL_S)
        # dpkg takes it itself.
        fcntl.lockf(own, fcntl.LOCK_UN)
        yield


def _is_taken(file: BinaryIO) -> bool:
    try:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def written_survey(processes: Path) -> Optional[Path]:
    """Return the folder of a survey that a process of this computer writes, if any.

    Every writer holds the lock of the survey's folder until the survey has ended, a paused one
    too. Whatever the data folder is, and whether or not the robot's nodes answer, it is found
    here. Only root sees the files of every process.
    """
    for entry in processes.glob("[0-9]*/fd/*"):
        # Processes end and close their files meanwhile.
        with contextlib.suppress(OSError):
            if entry.is_dir() and (entry / "survey.json").is_file() and _is_locked(entry):
                return Path(os.readlink(str(entry)))
    return None


def _is_locked(folder: Path) -> bool:
    descriptor = os.open(str(folder), os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False


def launched_by_hand(processes: Path) -> Optional[int]:
    """Return the number of a process that runs a robot without its services, if any."""
    for process in processes.glob("[0-9]*"):
        with contextlib.suppress(OSError):
            words = (process / "cmdline").read_bytes().split(b"\0")
            if any(one.endswith(b"/roslaunch") for one in words[:2]):
                group = (process / "cgroup").read_text(encoding="utf-8", errors="replace")
                if "/gpr20-" not in group:
                    return int(process.name)
    return None
