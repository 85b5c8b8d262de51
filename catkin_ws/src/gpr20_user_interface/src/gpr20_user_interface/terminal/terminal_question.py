"""A question on a terminal."""

from __future__ import annotations

import select
import sys
from typing import Callable

from gpr20_common.terminal_text import printable

POLL_S = 0.2
# In English and Spanish.
YES = ("y", "yes", "s", "si", "s\u00ed")


def can_ask() -> bool:
    """Return whether a person can read a question and answer it."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def is_confirmed(question: str, cancelled: Callable[[], bool]) -> bool:
    """Ask, and return whether the answer is yes.

    Args:
        question: One line.
        cancelled: Called repeatedly while nothing is entered; true ends the question with no.
    """
    print(f"{printable(question)} ", end="", flush=True)
    while not cancelled():
        ready, _, _ = select.select([sys.stdin], [], [], POLL_S)
        if ready:
            return sys.stdin.readline().strip().lower() in YES
    print(flush=True)
    return False
