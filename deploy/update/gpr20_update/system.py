"""What an update needs of the system: its places, programs, durable files and locks."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import subprocess
from pathlib import Path
from typing import BinaryIO, Mapping, NamedTuple, Optional, TextIO


class UpdateError(Exception):
    """An update or a return cannot be done; the text says why and what to do."""


class Paths:
    """The files of one computer.

    Args:
        root: Its / ; a folder in the tests.
    """

    def __init__(self, root: Path = Path("/")) -> None:
        self.root = root
        self.state = root / "var/lib/gpr20-update"
        self.kept = self.state / "kept"
        """The package of each version that is kept, and its SHA-256."""
        self.sources = self.state / "sources.list"
        self.lists = self.state / "lists"
        self.archives = self.state / "archives"
        """What was copied from the stick."""
        self.backups = self.state / "backups"
        self.journal = self.state / "journal.json"
        """gpr20-update.service looks for it too."""
        self.settings = root / "etc/gpr20/robot.conf"
        self.key = root / "etc/gpr20/release_key.asc"
        self.slots = root / "opt/gpr20/slots"
        self.current = root / "opt/gpr20/current"
        self.processes = root / "proc"
        self.dpkg = root / "var/lib/dpkg"


class Ended(NamedTuple):
    """How a program ended: its exit status, what it printed, and on standard error."""

    status: int
    output: str
    complaints: str

    @property
    def last_lines(self) -> str:
        """The end of what it printed, for people."""
        lines = [one.strip() for one in f"{self.output}\n{self.complaints}".splitlines()]
        return "; ".join([one for one in lines if one][-4:])


def run(*command: str, limit_s: float, more: Optional[Mapping[str, str]] = None) -> Ended:
    """Run a program to its end, in a session of its own: a terminal that is closed cannot end it.

    Args:
        *command: The program and its arguments.
        limit_s: How long it may take [s]; it is then killed with what it has started.
        more: Further variables of its environment.
    """
    # Not pipes, whose end would wait for what it leaves running.
    with _memory("output") as output, _memory("complaints") as complaints:
        ended = subprocess.run(
            ["timeout", "--signal=KILL", str(limit_s), *command],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=complaints,
            env={**os.environ, "LC_ALL": "C.UTF-8", **(more or {})},
            start_new_session=True,
            cwd="/",
            check=False,
        )
        output.seek(0)
        complaints.seek(0)
        return Ended(ended.returncode, output.read(), complaints.read())


def _memory(name: str) -> TextIO:
    return open(os.memfd_create(name), "w+", encoding="utf-8", errors="replace")


def sync(path: Path) -> None:
    """Return when a file, or the names in a folder, are durable."""
    descriptor = os.open(str(path), os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def replace_file(path: Path, data: bytes) -> None:
    """Give a file new content in one step, or leave it as it was; return when it is durable."""
    temporary = path.with_name(f".{path.name}.new")
    with contextlib.suppress(FileNotFoundError):
        temporary.unlink()
    descriptor = os.open(str(temporary), os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with open(descriptor, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(descriptor)
    os.replace(str(temporary), str(path))
    sync(path.parent)


def remove(folder: Path) -> None:
    """Remove a folder with everything in it, if it is there."""
    if folder.exists():
        shutil.rmtree(str(folder))
        sync(folder.parent)


def is_taken(file: BinaryIO) -> bool:
    """Take the lock of a file, if nobody has it; return whether this process has it now."""
    try:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
