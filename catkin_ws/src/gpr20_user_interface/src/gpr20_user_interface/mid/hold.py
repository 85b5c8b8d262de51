"""Holding a button: the deliberate act that everything needs that moves, ends or deletes."""

from __future__ import annotations

from typing import Optional

from gpr20_common.low.clock import Clock

HOLD_S = 1.0
# A window that was busy does not know whether the finger was there all the time: what lies
# between two looks counts as this time [s] at most.
MAX_STEP_S = 0.1


class Hold:
    """Measures how long a finger holds a button without a break.

    Args:
        clock: Measures the time.
        needed_s: How long it must be held [s].
    """

    def __init__(self, clock: Clock, needed_s: float = HOLD_S) -> None:
        self._clock = clock
        self._needed_s = needed_s
        self._held_s: Optional[float] = None
        self._looked_s = 0.0

    @property
    def active(self) -> bool:
        """Whether a finger holds the button."""
        return self._held_s is not None

    @property
    def fraction(self) -> float:
        """How much of the time has passed, 0 to 1."""
        return 0.0 if self._held_s is None else min(1.0, self._held_s / self._needed_s)

    def begin(self) -> None:
        """Note that a finger presses; one that comes to another finger ends the hold."""
        if self.active:
            self.cancel()
            return
        self._held_s = 0.0
        self._looked_s = self._clock.now_s()

    def cancel(self) -> None:
        """Note that the finger has left, or that what is under it has changed."""
        self._held_s = None

    def tick(self) -> bool:
        """Look at the clock; return whether the hold is complete. Each hold is so once."""
        if self._held_s is None:
            return False
        now_s = self._clock.now_s()
        self._held_s += min(now_s - self._looked_s, MAX_STEP_S)
        self._looked_s = now_s
        if self._held_s < self._needed_s:
            return False
        self.cancel()
        return True
