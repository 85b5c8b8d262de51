"""Waiting for a condition, with a limit that only a fault reaches, on the busiest computer too."""

from __future__ import annotations

import subprocess
import time
from typing import Callable, Sequence

LIMIT_S = 200.0
POLL_S = 0.005


def wait_until(
    condition: Callable[[], object],
    what: str = "the condition holds",
    alive: Sequence[subprocess.Popen] = (),
    limit_s: float = LIMIT_S,
    meanwhile: Callable[[], object] = lambda: time.sleep(POLL_S),
) -> None:
    """Return when a condition holds.

    Args:
        condition: It is asked again and again.
        what: What is waited for.
        alive: Processes that must run until then.
        limit_s: When it fails [s].
        meanwhile: What is done between two questions.
    """
    deadline_s = time.monotonic() + limit_s
    while not condition():
        for one in alive:
            assert one.poll() is None, f"{one.args!r} ended before {what}"
        assert time.monotonic() < deadline_s, f"not within {limit_s:g} s: {what}"
        meanwhile()
