"""The roslaunch that started this process."""

from __future__ import annotations

import os
import signal
import threading
from pathlib import Path
from typing import Optional

POLL_S = 0.1


def roslaunch_number() -> Optional[int]:
    """Return the process id of the roslaunch that started this process.

    Returns:
        None if rostest, a terminal or a debugger started it.
    """
    parent = os.getppid()
    try:
        words = Path(f"/proc/{parent}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return None
    is_roslaunch = any(Path(os.fsdecode(word)).name == "roslaunch" for word in words[:2])
    return parent if is_roslaunch else None


def end_with_roslaunch(number: int) -> None:
    """Ask a roslaunch to end, as Ctrl-C does, and wait until it ends this process.

    A process that ended by itself could be started again before roslaunch has reacted. A roslaunch
    that still starts nodes may leave the last of them behind: such a node ends after it.

    Args:
        number: Process id of the roslaunch that started this process.
    """
    os.kill(number, signal.SIGINT)
    never = threading.Event()
    while os.getppid() == number:
        never.wait(POLL_S)
