"""Child processes that never disturb a survey."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import threading
from pathlib import Path
from typing import Any, Sequence, Tuple

# Lowest priority for processor and disk; killed with the thread that started it.
PREFIX: Tuple[Tuple[str, ...], ...] = (
    ("nice", "-n", "19"),
    ("ionice", "-c", "3"),
    ("setpriv", "--pdeathsig", "KILL"),
)
LOWEST_NICE = 19
# The first to be killed if the memory of the computer runs out.
OOM_SCORE = 1000
MEMORY_SHARE, LEAST_MEMORY_BYTES = 0.5, 512 << 20
# As long as a command needs to leave no partial output behind.
END_LIMIT_S = 5.0


def memory_limit_bytes() -> int:
    """Return how much memory a child may use [bytes]: half of that of the computer."""
    total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return max(LEAST_MEMORY_BYTES, int(MEMORY_SHARE * total))


def start_child(command: Sequence[str], **options: Any) -> subprocess.Popen:
    """Start a process with the lowest priority and bounded memory.

    It is killed when the thread that calls this ends, so only threads that live as long as the
    node may call this.

    Args:
        command: The program and its arguments.
        options: For `subprocess.Popen`.

    Raises:
        OSError: It cannot be started.
    """
    lowered = [word for tool in PREFIX if shutil.which(tool[0]) for word in tool]
    child = subprocess.Popen([*lowered, *command], **options)
    limit = memory_limit_bytes()
    try:
        resource.prlimit(child.pid, resource.RLIMIT_DATA, (limit, limit))
        Path(f"/proc/{child.pid}/oom_score_adj").write_text(str(OOM_SCORE))
    except ProcessLookupError:
        return child  # it has ended already; its status says why
    return child


def end_child(child: subprocess.Popen) -> None:
    """Ask a process to end, and kill it if it does not; do not wait."""
    if child.poll() is not None:
        return
    child.terminate()
    killer = threading.Timer(END_LIMIT_S, child.kill)
    killer.daemon = True
    killer.start()


def lower_this_thread() -> None:
    """Give the calling thread, and what it starts, the lowest priority."""
    os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), LOWEST_NICE)
