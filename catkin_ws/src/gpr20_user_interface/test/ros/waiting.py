"""Waiting for what should happen, but not for ever."""

from __future__ import annotations

import time
from typing import Callable

LIMIT_S = 60.0
PAUSE_S = 0.02


def wait_until(
    condition: Callable[[], bool],
    what: str,
    pause: Callable[[], None] = lambda: time.sleep(PAUSE_S),
    limit_s: float = LIMIT_S,
) -> None:
    """Return when the condition holds; fail with `what` if it does not within the limit.

    Args:
        condition: Asked again and again.
        what: What is waited for, for the message.
        pause: Lets a little time pass; a window needs its events handled meanwhile.
        limit_s: How long to wait [s].
    """
    deadline_s = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > deadline_s:
            raise AssertionError(f"not within {limit_s:g} s: {what}")
        pause()
