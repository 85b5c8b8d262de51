"""Which browser may start and resume: one at a time, and taken over only in sight of its person."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, Dict, Mapping, Optional

from gpr20_common.faults import BUSY
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_web import faults
from gpr20_web.calls import Call, Person, Role, Route, text_of
from gpr20_web.errors import NotAllowedError, NotNowError
from gpr20_web.mid.web_page import WebPage

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
                Message("{name} asks for control already", name=self.asked.person.name), fault=BUSY
            )

    def keep(self, person: Person) -> None:
        """Refuse the request of another one.

        Raises:
            NotAllowedError: The person is not in control.
        """
        self.check(person)
        self.asked = None

    def give(self, person: Person, mark: str) -> None:
        """Let the one who asks have control.

        Args:
            person: Who is in control.
            mark: Of the browser that the person has seen asking.

        Raises:
            NotAllowedError: The person is not in control.
            NotNowError: It asks no longer.
        """
        self.check(person)
        if self.asked is None or self.asked.person.mark != mark:
            raise NotNowError(Message("who asked for control does not ask for it now"))
        self._give(self.asked.person)

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


class ControlPage(WebPage):
    """Taking, passing and giving up control, in sight of everybody."""

    words: Mapping[str, Message] = {
        "take": Message("Take control"),
        "ask": Message("Ask {name} for control", name="{name}"),
        "release": Message("Give control up"),
        "pass": Message("Pass control to {name}", name="{name}"),
        "keep": Message("Keep control"),
        "nobody": Message("Nobody is in control."),
        "you": Message("You are in control."),
        "other": Message("{name} is in control.", name="{name}"),
        "asked": Message(
            "{name} asks for control. It passes in {seconds} s.", name="{name}", seconds="{seconds}"
        ),
    }

    def __init__(self, controller: Controller, clock: Clock) -> None:
        self._controller, self._clock = controller, clock
        steps = {"take": self._take, "release": self._release, "pass": self._pass}
        steps["keep"] = self._keep
        self.routes = tuple(
            Route("POST", f"/api/control/{name}", Role.CONTROL, step)
            for name, step in steps.items()
        )

    def refresh(self, snapshot: Snapshot) -> None:
        """Let control pass when its time has come."""
        self._controller.refresh()

    def live(self, text: Callable[[Message], str]) -> Mapping[str, Any]:
        """Return who is in control, and who asks for it."""
        holder, asked = self._controller.holder, self._controller.asked
        waits = None
        if asked is not None:
            left_s = max(0.0, asked.passes_s - self._clock.now_s())
            waits = {**_browser(asked.person), "passes_s": math.ceil(left_s)}
        return {"control": {"holder": None if holder is None else _browser(holder), "asked": waits}}

    def _take(self, call: Call) -> Mapping[str, Any]:
        self._controller.take(call.who)
        return {}

    def _release(self, call: Call) -> Mapping[str, Any]:
        self._controller.release(call.who)
        return {}

    def _pass(self, call: Call) -> Mapping[str, Any]:
        self._controller.give(call.who, text_of(call, "mark"))
        return {}

    def _keep(self, call: Call) -> Mapping[str, Any]:
        self._controller.keep(call.who)
        return {}


def _browser(person: Person) -> Dict[str, Any]:
    return {"name": person.name, "mark": person.mark}
