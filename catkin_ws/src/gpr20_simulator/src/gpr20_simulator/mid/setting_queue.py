"""Settings that take effect some time after they were sent."""

from __future__ import annotations

from collections import deque
from typing import Callable, Deque, Tuple

from gpr20_common.low.clock import Clock


class SettingQueue:
    """Keeps settings back, as the instrument may do for up to two seconds.

    Args:
        clock: Tells the time.
        delay_s: How long each setting takes [s]; 0: none at all.
    """

    def __init__(self, clock: Clock, delay_s: float) -> None:
        self._clock = clock
        self._delay_s = delay_s
        self._waiting: Deque[Tuple[float, Callable[[], None]]] = deque()

    def put(self, apply: Callable[[], None]) -> None:
        """Take a setting; without a delay it takes effect now."""
        self._waiting.append((self._clock.now_s() + self._delay_s, apply))
        self.apply_due()

    def apply_due(self) -> None:
        """Let those settings take effect whose time has come, in their order."""
        while self._waiting and self._waiting[0][0] <= self._clock.now_s():
            _due_s, apply = self._waiting.popleft()
            apply()

    def clear(self) -> None:
        """Forget what has not taken effect."""
        self._waiting.clear()
