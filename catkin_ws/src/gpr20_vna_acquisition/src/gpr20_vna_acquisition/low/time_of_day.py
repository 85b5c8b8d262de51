"""The time of day, for time stamps."""

from __future__ import annotations

import time
from typing import Callable


class TimeOfDay:
    """Gives time stamps whose differences a correction of the clock cannot spoil."""

    def __init__(
        self,
        wall_ns: Callable[[], int] = time.time_ns,
        steady_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._wall_ns = wall_ns
        self._steady_ns = steady_ns

    def begin(self) -> Interval:
        """Begin an interval now."""
        return Interval(self._wall_ns(), self._steady_ns)


class Interval:
    """Begins at a time of day; its later moments are counted from there by a steady clock."""

    def __init__(self, started_ns: int, steady_ns: Callable[[], int]) -> None:
        self._started_ns = started_ns
        self._steady_ns = steady_ns
        self._origin_ns = steady_ns()

    @property
    def started_us(self) -> int:
        """When it began [whole microseconds since 1970, UTC]."""
        return self._started_ns // 1000

    def now_us(self) -> int:
        """Return the present moment [whole microseconds since 1970, UTC]."""
        return (self._started_ns + self._steady_ns() - self._origin_ns) // 1000
