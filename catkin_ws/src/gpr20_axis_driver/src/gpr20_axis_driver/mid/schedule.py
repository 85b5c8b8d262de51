"""When the edges of a motion's pulses are due, and what a late one does to the rest."""

from __future__ import annotations

from array import array

from gpr20_axis_driver.mid.motion import LateLimits
from gpr20_survey.axes.ramp import Ramp


class Schedule:
    """Absolute moments of a motion's edges, told when each was really made.

    A delay up to the limit is absorbed: the next edges stay where they were, so a pause
    can be shorter than its due length by up to that limit, never by more. Beyond the limit the rest
    is shifted as a whole, and continues at the speed that the gap means: no burst follows.
    """

    def __init__(self, ramp: Ramp, limits: LateLimits, start_s: float) -> None:
        """Begin with the slowest pause at `start_s` [s of the clock]."""
        self.due_s = start_s
        self.pause_s = ramp.max_pause_s
        self.lateness_s = array("d")
        self.slowed = 0
        self.gap_s = 0.0
        self._ramp = ramp
        self._limits = limits
        self._height = 0
        self._excess_s = 0.0

    def rise(self, now_s: float, steps_left: int) -> None:
        """Take note of a rising edge; `due_s` becomes the moment of its falling edge.

        Args:
            now_s: When it is made [s of the clock].
            steps_left: How many steps are left, with this one.
        """
        late_s = now_s - self.due_s
        self.lateness_s.append(late_s)
        if late_s > self._limits.late_s:
            self._shift(late_s)
        self._excess_s = 0.0
        self.pause_s = self._ramp.pause_s(min(self._height, steps_left - 1))
        self._height += 1
        self.due_s += self.pause_s

    def fall(self, now_s: float) -> None:
        """Take note of a falling edge; `due_s` becomes the moment of the next rising edge."""
        late_s = now_s - self.due_s
        if late_s > self._limits.late_s:
            self._shift(late_s)
        self.due_s += self.pause_s

    def too_late(self, now_s: float) -> bool:
        """Return whether the motor can have lost its steps while it waited for this edge."""
        # At the slowest speed the motor may stop and start on any step.
        if self.pause_s >= self._ramp.max_pause_s:
            return False
        gap_s = self._excess_s + now_s - self.due_s
        if gap_s <= self._limits.gap_s:
            return False
        self.gap_s = gap_s
        return True

    def _shift(self, late_s: float) -> None:
        self.slowed += 1
        self.due_s += late_s
        self._excess_s += late_s
        # The step took two pauses and the delay: it was as slow as this.
        pause_s = self.pause_s + self._excess_s / 2.0
        self._height = min(self._height, self._ramp.height_after(pause_s))
