"""Which touches count: none right after a change under the finger, none on a locked screen.

STOP always counts.
"""

from __future__ import annotations

import enum
import math
from typing import Optional

from gpr20_common.low.clock import Clock

# How long a button must be held [s].
HOLD_S = 1.0
# A window that was busy does not know whether the finger was there all the time: what lies
# between two looks counts as this time [s] at most.
MAX_STEP_S = 0.1


class Hold:
    """Measures how long a finger holds a button without a break."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._held_s: Optional[float] = None
        self._looked_s = 0.0

    @property
    def active(self) -> bool:
        """Whether a finger holds the button."""
        return self._held_s is not None

    @property
    def fraction(self) -> float:
        """How much of the time has passed, 0 to 1."""
        return 0.0 if self._held_s is None else min(1.0, self._held_s / HOLD_S)

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
        if self._held_s < HOLD_S:
            return False
        self.cancel()
        return True


# After a change [s]: a bounced touch comes within about 0.15 s; a person needs longer to see what
# has opened.
QUIET_S = 0.4


class TouchTarget(enum.Enum):
    """What a touch begins on."""

    STOP = "stop"
    UNLOCK = "unlock"
    OTHER = "other"
    TOO_SMALL = "too small"
    """What a gloved finger does not hit alone on this screen."""
    DIMMED = "dimmed"
    """What nobody sees well."""


class _Touch(enum.Enum):
    """What becomes of the touch that is there."""

    NONE = enum.auto()
    IGNORED = enum.auto()
    TAKEN = enum.auto()
    # Of STOP: nothing ends it but the finger.
    STOP = enum.auto()


class TouchGuard:
    """Decides about touches. Belongs to one thread.

    Attributes:
        locked: Whether the screen is locked against touches.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._changed_s = -math.inf
        self._touch = _Touch.NONE
        self.locked = False

    @property
    def quiet(self) -> bool:
        """Whether what is under a finger has just changed."""
        return self._clock.now_s() - self._changed_s < QUIET_S

    @property
    def taken(self) -> bool:
        """Whether there is a touch that counts."""
        return self._touch in (_Touch.TAKEN, _Touch.STOP)

    @property
    def touching(self) -> bool:
        """Whether there is a touch, whether it counts or not."""
        return self._touch is not _Touch.NONE

    def press(self, target: TouchTarget) -> bool:
        """Begin a touch; return whether it counts."""
        if target is TouchTarget.STOP:
            self._touch = _Touch.STOP
        elif self._allows(target):
            self._touch = _Touch.TAKEN
        else:
            self._touch = _Touch.IGNORED
        return self.taken

    def release(self) -> bool:
        """End the touch; return whether it counted to its end."""
        taken, self._touch = self.taken, _Touch.NONE
        return taken

    def note_change(self) -> bool:
        """Note that something was opened or closed under the finger.

        Returns:
            Whether a touch that counted is to be dropped: it was meant for something else.
        """
        self._changed_s = self._clock.now_s()
        return self.drop()

    def set_locked(self, locked: bool) -> bool:
        """Lock or unlock the screen; return as `note_change`."""
        self.locked = locked
        return self.note_change()

    def drop(self) -> bool:
        """Take the touch no more, as when another finger comes; return as `note_change`."""
        if self._touch is not _Touch.TAKEN:
            return False
        self._touch = _Touch.IGNORED
        return True

    def _allows(self, target: TouchTarget) -> bool:
        if self.quiet or target in (TouchTarget.TOO_SMALL, TouchTarget.DIMMED):
            return False
        return not self.locked or target is TouchTarget.UNLOCK
