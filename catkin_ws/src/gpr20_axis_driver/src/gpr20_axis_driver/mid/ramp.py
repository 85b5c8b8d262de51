"""How fast an axis steps: the pauses of a move, as plain numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator


@dataclass(frozen=True)
class Ramp:
    """Pauses of half a step period, changing by at most `delta_s` from step to step.

    Attributes:
        min_pause_s: Shortest pause [s], at top speed.
        max_pause_s: Longest pause [s], at the first and the last step.
        delta_s: Change of the pause per step [s].
    """

    min_pause_s: float
    max_pause_s: float
    delta_s: float

    def pauses_s(self, steps: int) -> Iterator[float]:
        """Yield the pause [s] of each step of a move.

        The move speeds up from the slowest pause, runs at the shortest and slows down
        again; if it is too short for that, it turns round half way. No shorter move of
        as many steps keeps the bounds, because each pause is as short as the way from
        the start and the way to the end allow.
        """
        for step in range(steps):
            from_end = min(step, steps - 1 - step)
            yield max(self.min_pause_s, self.max_pause_s - self.delta_s * from_end)

    def braking_pauses_s(self, pause_s: float) -> Iterator[float]:
        """Yield the pauses [s] that bring an axis from a pause to the slowest one."""
        for step in range(1, self.braking_steps(pause_s) + 1):
            yield min(self.max_pause_s, pause_s + self.delta_s * step)

    def braking_steps(self, pause_s: float) -> int:
        """Return how many steps an axis needs to come from a pause to the slowest one."""
        # The tolerance keeps a rounding error of the pauses from adding a step.
        return max(0, math.ceil((self.max_pause_s - pause_s) / self.delta_s - 1.0e-9))

    def duration_s(self, steps: int) -> float:
        """Return how long a move takes [s]; each step is two pauses."""
        ramp_steps = min(self.braking_steps(self.min_pause_s), steps // 2)
        ramp_s = sum(
            max(self.min_pause_s, self.max_pause_s - self.delta_s * step)
            for step in range(ramp_steps)
        )
        middle = steps - 2 * ramp_steps
        middle_pause_s = max(self.min_pause_s, self.max_pause_s - self.delta_s * ramp_steps)
        return 2.0 * (2.0 * ramp_s + middle * middle_pause_s)
