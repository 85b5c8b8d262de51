"""The roslaunch that started this process."""

from __future__ import annotations

import os
import signal
from pathlib import Path


def end_roslaunch() -> bool:
    """Ask the roslaunch that started this process to end, as Ctrl-C does.

    Returns:
        Whether roslaunch started it; rostest, a terminal or a debugger is left alone.
    """
    parent = os.getppid()
    try:
        words = Path(f"/proc/{parent}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return False
    if not any(Path(os.fsdecode(word)).name == "roslaunch" for word in words[:2]):
        return False
    os.kill(parent, signal.SIGINT)
    return True
