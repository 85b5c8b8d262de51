"""Who is in control, what was pressed, what became of it, and the notes of who pressed it."""

from __future__ import annotations

import enum
import math
import re
from collections import OrderedDict, deque
from dataclasses import dataclass
from typing import Any, Callable, Deque, Dict, List, Mapping, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.jobs.job import Job, Requests, Service
from gpr20_operator.robot.condition import first_step
from gpr20_operator.robot.events import Answer, Request
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.trace.utc_time import iso_text
from gpr20_web.calls import Call, Person, Text, text_of
from gpr20_web.faults import (
    NOT_IN_CONTROL,
    NOT_NOTED,
    BadRequestError,
    NotAllowedError,
    NotNowError,
)

# A browser that has lost its link for so long [s] gives control up.
ABSENT_S = 30.0
# The browser makes a new one for each press.
_PRESS_ID = re.compile("[0-9a-f]{32}")
# A press that is sent again within this many others is not carried out again.
KNOWN_PRESSES = 500
# An answer that has not come by then [s] is called unknown; homing may take longer than the rest.
ANSWER_S = {Request.STOP: 5.0, Request.PAUSE: 12.0, Request.START: 1200.0, Request.RESUME: 1200.0}
# A browser gives a command up after 5 s; its telephone may deliver it much later [s].
LATE_S = 6.0
# How far a browser's idea of the clock of `sent_ms` may be ahead [s].
AHEAD_S = 2.0
# Of a text in an entry of the log; a browser may send more.
MOST_CHARACTERS = 200
# A note that the storage did not take is sent again after so long, and given up when it is so old:
# its survey may be gone [s].
RETRY_S, NOTE_LIMIT_S = 10.0, 3600.0


class Outcome(enum.Enum):
    """What is known of a command."""

    SENT = "sent"
    DONE = "done"
    REFUSED = "refused"
    UNKNOWN = "unknown"


@dataclass
class Command:
    """A press, and what became of it.

    Attributes:
        answered: Whether its answer came, or another one of the same kind.
    """

    press: str
    request: Request
    call: Call
    sent_s: float
    outcome: Outcome = Outcome.SENT
    said: Optional[Message] = None
    answered: bool = False


class Presses:
    """The last commands of all persons.

    Attributes:
        last: The last one; None: there was none.
    """

    def __init__(self) -> None:
        self._known: OrderedDict[str, Command] = OrderedDict()
        self.last: Optional[Command] = None
        self._stopped_s = -math.inf

    def __contains__(self, press: str) -> bool:
        """Return whether a press was sent before."""
        return press in self._known

    def add(self, press: str, request: Request, call: Call, now_s: float) -> None:
        """Note a command that was passed on."""
        if request is Request.STOP:
            self._stopped_s = now_s
        self.last = self._known[press] = Command(press, request, call, now_s)
        while len(self._known) > KNOWN_PRESSES:
            self._known.popitem(last=False)

    def check_age(self, call: Call, now_s: float) -> None:
        """Check that a command was pressed just now, and after the last STOP.

        Raises:
            BadRequestError: It does not say when it was pressed.
            NotNowError: It was long on its way.
        """
        pressed_ms = call.values.get("pressed_ms")
        if not isinstance(pressed_ms, (int, float)):
            raise BadRequestError(Message("the request does not say when it was pressed"))
        first_s = max(now_s - LATE_S, self._stopped_s)
        if not 1e3 * first_s <= pressed_ms <= 1e3 * (now_s + AHEAD_S):
            raise NotNowError(
                Message(
                    "the request was too long on its way, or STOP was pressed since; press again "
                    "if you still want it"
                )
            )

    def waiting(self, request: Request) -> List[Command]:
        """Return those that are not answered yet."""
        known = self._known.values()
        return [one for one in known if one.request is request and not one.answered]

    def end(self, answer: Answer) -> List[Command]:
        """Take an answer; return the commands that it ends."""
        ended = self.waiting(answer.request)
        outcome = Outcome.DONE if answer.success else Outcome.REFUSED
        for one in ended:
            # A STOP without contact is sent again: its answer is still to come.
            one.answered = answer.contact or answer.request is not Request.STOP
            one.said = answer.message
            one.outcome = outcome if answer.contact else Outcome.UNKNOWN
        return ended

    def refresh(self, now_s: float) -> None:
        """Call the last one unknown when its answer is late."""
        last = self.last
        if last is not None and not last.answered and now_s - last.sent_s > ANSWER_S[last.request]:
            last.outcome = Outcome.UNKNOWN

    def values(self, text: Text) -> Optional[Mapping[str, Any]]:
        """Return the last one for browsers."""
        last = self.last
        if last is None:
            return None
        refused = None if last.outcome is not Outcome.REFUSED else last.said
        first = None if refused is None else first_step(refused)
        return {
            "press": last.press,
            "request": last.request.value,
            "name": last.call.who.name,
            "outcome": last.outcome.value,
            "text": "" if last.said is None else text(last.said),
            "remedy": "" if first is None else text(first),
        }


def press_of(call: Call) -> str:
    """Return the mark of a press.

    Raises:
        BadRequestError: It has none.
    """
    press = text_of(call, "press")
    if not _PRESS_ID.fullmatch(press):
        raise BadRequestError(Message("the request has no mark of its press"))
    return press


def log_entry(call: Call, what: str, outcome: str, clock: Clock) -> Dict[str, Any]:
    """Return who did what, for the log of a survey."""
    return {
        "time": iso_text(clock.time_of_day_us()),
        "user": call.who.name,
        "role": call.who.role.word,
        "address": call.address,
        "command": what,
        "outcome": outcome[:MOST_CHARACTERS],
    }


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
            fault=NOT_IN_CONTROL,
        )


class AuditNotes:
    """Adds notes to the logs of surveys, one at a time; nobody waits for that.

    What fails is sent again behind the others. Belongs to one thread.

    Args:
        requests: Reach the storage.
        now_s: A clock that never goes back [s].
        report: Takes the first problem after a note that was taken.

    Attributes:
        waiting: What no log has yet, the next one first, with the time when it is given up.
        problem: Why the last note was not taken; None if it was.
        last_tries: After `finish`, how many notes are still to be sent; before, None.
    """

    def __init__(
        self, requests: Requests, now_s: Callable[[], float], report: Callable[[Message], None]
    ) -> None:
        self._now_s, self._report = now_s, report
        self.waiting: Deque[Tuple[float, Mapping[str, Any]]] = deque()
        self._next_s = now_s()
        self._job = Job(requests, Service.FACT, now_s, self._on_taken, self._on_failed)
        self.problem: Optional[Message] = None
        self.last_tries: Optional[int] = None
        self._ended: Callable[[], None] = lambda: None

    def add(self, survey: str, values: Mapping[str, Any]) -> None:
        """Add values to the log of a survey, by its id."""
        fact = {"survey": survey, "kind": Kind.AUDIT, "values": values}
        self.waiting.append((self._now_s() + NOTE_LIMIT_S, fact))
        self.refresh()

    def finish(self, ended: Callable[[], None]) -> None:
        """Send what waits once more, at once; `ended` is called when all of it was answered."""
        self.last_tries, self._ended = len(self.waiting), ended
        self._next_s = self._now_s()
        self.refresh()

    def refresh(self) -> None:
        """Send what waits, when it is time."""
        if self.last_tries == 0:
            self._ended()
        elif self.waiting and not self._job.running and self._now_s() >= self._next_s:
            self._job.ask(**self.waiting[0][1])

    def _on_taken(self, _said: Message) -> None:
        self.waiting.popleft()
        self.problem = None
        self._go_on(0.0)

    def _on_failed(self, reason: Message) -> None:
        note, now_s, former = self.waiting.popleft(), self._now_s(), self.problem
        if now_s < note[0]:
            self.waiting.append(note)
        text = Message("a command was not noted in the log of its survey: {reason}", reason=reason)
        self.problem = text.with_fault(NOT_NOTED)
        if former is None:
            self._report(self.problem)
        self._go_on(RETRY_S)

    def _go_on(self, pause_s: float) -> None:
        if self.last_tries is not None:
            self.last_tries, pause_s = self.last_tries - 1, 0.0
        self._next_s = self._now_s() + pause_s
        self.refresh()
