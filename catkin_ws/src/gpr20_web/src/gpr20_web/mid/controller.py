"""Which browser may start and resume: one at a time, and taken over only in sight of its person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web import faults
from gpr20_web.calls import Person
from gpr20_web.errors import NotAllowedError

# Who does not answer the request of another one for so long [s] is not there.
ANSWER_S = 20.0
# A browser that has lost its link for so long [s] gives control up.
ABSENT_S = 30.0


@dataclass(frozen=True)
class TakeOver:
    """Somebody asks for control; it passes at a time of the clock [s] unless it is refused."""

    person: Person
    passes_s: float


class Controller:
    """Who is in control. Belongs to one thread.

    Args:
        clock: Measures how long a request waits and a browser is absent.
        is_present: Whether the browser of a session watches now.

    Attributes:
        holder: Who is in control; None: nobody.
        asked: The request of another one; None: there is none.
    """

    def __init__(self, clock: Clock, is_present: Callable[[str], bool]) -> None:
        self._now_s = clock.now_s
        self._is_present = is_present
        self._seen_s = 0.0
        self.holder: Optional[Person] = None
        self.asked: Optional[TakeOver] = None

    def refresh(self) -> None:
        """Let control pass, or lapse, when its time has come."""
        now_s = self._now_s()
        if self.holder is not None and self._is_present(self.holder.session):
            self._seen_s = now_s
        if self.holder is not None and now_s - self._seen_s > ABSENT_S:
            self.holder = None
        asked = self.asked
        if asked is not None and not self._is_present(asked.person.session):
            self.asked = None
        elif asked is not None and (self.holder is None or now_s >= asked.passes_s):
            self._give(asked.person)

    def take(self, person: Person) -> None:
        """Take control, or ask who has it.

        Raises:
            NotAllowedError: Somebody else asks already.
        """
        self.refresh()
        if self.holder is None or self.has(person):
            self._give(person)
        elif self.asked is None or self.asked.person.session == person.session:
            self.asked = self.asked or TakeOver(person, self._now_s() + ANSWER_S)
        else:
            raise NotAllowedError(
                Message("{name} asks for control already", name=self.asked.person.name)
            )

    def answer(self, person: Person, passes: bool) -> None:
        """Answer the request of another one.

        Raises:
            NotAllowedError: The person is not in control.
        """
        self.check(person)
        if self.asked is not None and passes:
            self._give(self.asked.person)
        self.asked = None

    def release(self, person: Person) -> None:
        """Give control up, or a request for it."""
        if self.has(person):
            self.holder = None
        if self.asked is not None and self.asked.person.session == person.session:
            self.asked = None
        self.refresh()

    def has(self, person: Person) -> bool:
        """Return whether it is this browser that is in control."""
        return self.holder is not None and self.holder.session == person.session

    def check(self, person: Person) -> None:
        """Raise NotAllowedError unless it is this browser that is in control."""
        self.refresh()
        if self.has(person):
            return
        raise NotAllowedError(
            Message("another page is in control: {name}", name=self.holder.name)
            if self.holder is not None
            else Message("this page is not in control"),
            fault=faults.NOT_IN_CONTROL,
        )

    def _give(self, person: Person) -> None:
        self.holder, self.asked, self._seen_s = person, None, self._now_s()
