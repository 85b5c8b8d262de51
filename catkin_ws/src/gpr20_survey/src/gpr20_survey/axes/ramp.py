"""How fast an axis steps: the pauses of a move, as plain numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

# Prevents a rounding error of the pauses from adding or removing a step.
ROUNDING = 1.0e-9


@dataclass(frozen=True)
class Ramp:
    """Pauses of half a step period, changing by at most `delta_s` from step to step."""

    min_pause_s: float
    max_pause_s: float
    delta_s: float

    def pause_s(self, height: int) -> float:
        """Return the pause [s] so many steps up the ramp; 0 is the slowest."""
        return max(self.min_pause_s, self.max_pause_s - self.delta_s * height)

    def height_after(self, pause_s: float) -> int:
        """Return how high on the ramp the step after one with this pause [s] may be."""
        if pause_s >= self.max_pause_s:
            return 0
        return math.floor((self.max_pause_s - pause_s) / self.delta_s + ROUNDING) + 1

    def braking_steps(self, pause_s: float) -> int:
        """Return how many steps an axis needs to come from a pause to the slowest one."""
        return max(0, math.ceil((self.max_pause_s - pause_s) / self.delta_s - ROUNDING))

    def duration_s(self, steps: int) -> float:
        """Return how long a move takes [s]; each step is two pauses."""
        ramp_steps = min(self.braking_steps(self.min_pause_s), steps // 2)
        ramp_s = sum(self.pause_s(step) for step in range(ramp_steps))
        middle = steps - 2 * ramp_steps
        return 2.0 * (2.0 * ramp_s + middle * self.pause_s(ramp_steps))
