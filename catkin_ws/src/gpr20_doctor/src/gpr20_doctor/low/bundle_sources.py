"""Where the parts of a bundle come from: commands, and the ends of files."""

from __future__ import annotations

import codecs
import os
from pathlib import Path
from typing import Iterator, List, Sequence, Tuple

from gpr20_survey.files.regular_file import open_regular

UNITS = ("robot", "server", "firewall", "window", "update")
# Each is short, and none changes anything.
COMMANDS: Sequence[Tuple[str, Sequence[str]]] = (
    ("system/kernel.txt", ("uname", "-a")),
    ("system/packages.txt", ("dpkg-query", "-W", "gpr20-*", "ros-*", "python3", "chrony")),
    ("system/disks.txt", ("df", "-hT")),
    ("system/mounts.txt", ("findmnt", "-l")),
    ("system/memory.txt", ("free", "-m")),
    ("system/processes.txt", ("ps", "-eo", "pid,ppid,stat,etimes,%cpu,rss,comm", "--sort=-rss")),
    ("system/addresses.txt", ("ip", "-brief", "addr")),
    ("system/routes.txt", ("ip", "route")),
    ("system/listening.txt", ("ss", "-ltn")),
    ("system/clock.txt", ("chronyc", "-n", "sources")),
    ("system/firewall.txt", ("nft", "list", "ruleset")),
    ("system/kernel_log.txt", ("dmesg", "--level=emerg,alert,crit,err,warn", "--ctime")),
    (
        "logs/services.txt",
        ("journalctl", "--no-pager", "-o", "short-iso", "-n", "3000")
        + tuple(f"--unit=gpr20-{one}" for one in UNITS),
    ),
)


def end_of(path: Path, most_bytes: int, follow_link: bool = False) -> str:
    """Return the end of a regular file, in whole lines.

    Raises:
        OSError: It cannot be read.
        IrregularFileError: It is a link, a device or a pipe.
    """
    with open(open_regular(path, follow_link), "rb") as stream:
        skipped = max(0, os.fstat(stream.fileno()).st_size - most_bytes)
        stream.seek(skipped)
        # A file that grows does not make the bundle grow.
        text = _decoded(stream.read(most_bytes))
    return text.partition("\n")[2] if skipped else text


def _decoded(content: bytes) -> str:
    """Return a text as YAML reads it: UTF-16 too, whose secrets would not be found as UTF-8."""
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return content.decode("utf-16" if marked else "utf-8", errors="replace")


def newest(folder: Path, pattern: str) -> List[Path]:
    """Return the files below a folder, the newest first; links are left out."""
    return [path for _time, path in sorted(_dated(folder, pattern), reverse=True)]


def _dated(folder: Path, pattern: str) -> Iterator[Tuple[float, Path]]:
    for path in folder.glob(pattern):
        try:
            # The folder `latest` of roslaunch is a link to one that is listed itself.
            if not any(one.is_symlink() for one in (path, path.parent)):
                yield path.stat().st_mtime, path
        except OSError:
            continue  # it was removed in the meantime
