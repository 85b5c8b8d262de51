"""Which browser may start and resume: one at a time, while its tab and its link last."""

from __future__ import annotations

from typing import Callable, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web import faults
from gpr20_web.calls import Person
from gpr20_web.errors import NotAllowedError

# A browser that has lost its link for so long [s] gives control up.
ABSENT_S = 30.0


class Lease:
    """Who is in control. Belongs to one thread.

    It passes to whoever takes it, except while a person at the robot allows remote control to the
    browser that has it now.

    Args:
        clock: Measures how long a browser is absent.
        is_present: Whether the browser of a session watches now.

    Attributes:
        holder: Who is in control; None: nobody.
    """

    def __init__(self, clock: Clock, is_present: Callable[[str], bool]) -> None:
        self._now_s, self._is_present = clock.now_s, is_present
        self._seen_s, self._allowed = 0.0, False
        self.holder: Optional[Person] = None

    def refresh(self, allowed: bool) -> None:
        """Let control lapse when its time has come.

        Args:
            allowed: Whether a person at the robot allows remote control now.
        """
        now_s = self._now_s()
        if self.holder is not None and self._is_present(self.holder.session):
            self._seen_s = now_s
        if now_s - self._seen_s > ABSENT_S:
            self.holder = None
        self._allowed &= allowed

    def take(self, person: Person, allowed: bool) -> None:
        """Give control to a person, or raise NotAllowedError: somebody else has it.

        Args:
            person: Who takes it.
            allowed: See `refresh`.
        """
        self.refresh(allowed)
        if self.holder is not None and self._allowed:
            self.check(person)
        self.holder, self._seen_s, self._allowed = person, self._now_s(), allowed

    def release(self, person: Person) -> None:
        """Give control up."""
        if self.has(person):
            self.holder = None

    def has(self, person: Person) -> bool:
        """Return whether it is this browser that is in control."""
        return self.holder is not None and self.holder.session == person.session

    def check(self, person: Person) -> None:
        """Raise NotAllowedError unless it is this browser that is in control."""
        if self.has(person):
            return
        raise NotAllowedError(
            Message("another page is in control: {name}", name=self.holder.name)
            if self.holder is not None
            else Message("this page is not in control"),
            fault=faults.NOT_IN_CONTROL,
        )
