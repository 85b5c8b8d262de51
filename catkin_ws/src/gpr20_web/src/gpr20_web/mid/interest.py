"""What costs something is followed only while somebody looks at it."""

from __future__ import annotations

from typing import Callable

from gpr20_common.low.clock import Clock

# Who looks asks again within this time [s].
INTEREST_S = 10.0


class Interest:
    """Begins to follow when somebody asks, and ends when nobody has asked for a while.

    Args:
        follow: Begins or ends; it does not wait.
    """

    def __init__(self, follow: Callable[[bool], None], clock: Clock) -> None:
        self._follow, self._now_s = follow, clock.now_s
        self._asked_s = 0.0
        self.follows = False

    def ask(self) -> None:
        """Note that somebody looks."""
        self._asked_s = self._now_s()
        self._set(True)

    def refresh(self) -> None:
        """End when nobody looks any more."""
        self._set(self.follows and self._now_s() - self._asked_s <= INTEREST_S)

    def _set(self, follows: bool) -> None:
        if follows is not self.follows:
            self.follows = follows
            self._follow(follows)
