"""Server-sent events: to each browser its document when it changes, no faster than it reads."""

from __future__ import annotations

import asyncio
import json
import math
import time
from dataclasses import dataclass, field
from functools import partial
from typing import (
    Any,
    Awaitable,
    Callable,
    Dict,
    FrozenSet,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Protocol,
    Tuple,
)

from tornado.iostream import StreamClosedError

from gpr20_common.message import Message
from gpr20_web import faults
from gpr20_web.calls import Person, Stream
from gpr20_web.errors import BusyError, NotLoggedInError

MAX_STREAMS = 64
MAX_STREAMS_OF_PERSON = 30
# A browser has six connections to one computer for all its pages: STOP needs one.
MAX_STREAMS_OF_SESSION = 3
BEAT_S = 0.2
# While nobody watches.
REST_S = 0.5
# Without a change that matters at once; a browser shows what it has as old after 5 s.
SIGN_OF_LIFE_S = 1.0
# How often a stream asks whether its person may still watch.
SESSION_CHECK_S = 5.0


class Sender(Protocol):
    """An answer that is not finished."""

    def write(self, chunk: bytes) -> Any:
        """Add to what is sent."""

    def flush(self) -> Awaitable[Any]:
        """Return when the browser's connection has taken it."""


class Texts(NamedTuple):
    """A document as it is sent: all of it, and the parts that a browser is to have at once."""

    whole: str
    urgent: str


@dataclass(eq=False)
class Watcher:
    """A stream to a browser.

    Attributes:
        sent: What it knows; None: nothing.
        busy: Whether its connection has not yet taken what was sent.
        gone: Set when it has ended.
    """

    sender: Sender
    stream: Stream
    person: Person
    checked_s: float
    sent: Optional[Texts] = None
    sent_s: float = 0.0
    busy: bool = False
    gone: asyncio.Event = field(default_factory=asyncio.Event)


class EventStreams:
    """All browsers that watch; belongs to the thread of the event loop.

    Args:
        check: Raises NotLoggedInError if the person of a session may no longer watch.
        report: Takes an exception that no error of the project is.

    Attributes:
        fresh_s: When what is shown was made; infinite: it is as new as what is sent.
    """

    def __init__(
        self, check: Callable[[Person], None], report: Callable[[BaseException], None]
    ) -> None:
        self._check, self._report = check, report
        self._watchers: List[Watcher] = []
        self.fresh_s = math.inf

    def __len__(self) -> int:
        return len(self._watchers)

    def add(self, sender: Sender, stream: Stream, person: Person) -> Watcher:
        """Add a browser.

        Raises:
            BusyError: There are too many.
        """
        own = [one.person.session for one in self._watchers if one.person.name == person.name]
        of_session = own.count(person.session)
        if (
            len(self) >= MAX_STREAMS
            or len(own) >= MAX_STREAMS_OF_PERSON
            or of_session >= MAX_STREAMS_OF_SESSION
        ):
            raise BusyError(
                Message(
                    "too many pages are open (at most {one} in one browser, {own} of one account, "
                    "{most} in all); close one",
                    one=MAX_STREAMS_OF_SESSION,
                    own=MAX_STREAMS_OF_PERSON,
                    most=MAX_STREAMS,
                ),
                fault=faults.BAD_REQUEST,
            )
        watcher = Watcher(sender, stream, person, time.monotonic())
        self._watchers.append(watcher)
        return watcher

    def has(self, session: str) -> bool:
        """Return whether a browser of a session watches now."""
        return any(one.person.session == session for one in self._watchers)

    def remove(self, watcher: Watcher) -> None:
        self._watchers.remove(watcher)

    def end(self) -> None:
        for watcher in self._watchers:
            watcher.gone.set()

    async def run(self) -> None:
        """Send what changes until this is cancelled."""
        while True:
            await asyncio.sleep(BEAT_S if self._watchers else REST_S)
            # Browsers of one language share a document, by its identity; it is kept meanwhile.
            known: Dict[int, Tuple[Mapping[str, Any], Texts]] = {}
            now_s = time.monotonic()
            for watcher in [one for one in self._watchers if not one.busy]:
                try:
                    self._send_news(watcher, known, now_s)
                except NotLoggedInError:
                    watcher.gone.set()
                except Exception as error:  # one browser's trouble is not that of the others
                    self._report(error)
                    watcher.gone.set()

    def _send_news(
        self, watcher: Watcher, known: Dict[int, Tuple[Mapping[str, Any], Texts]], now_s: float
    ) -> None:
        if now_s - watcher.checked_s > SESSION_CHECK_S:
            watcher.checked_s = now_s
            self._check(watcher.person)
        document = watcher.stream.document()
        if id(document) not in known:
            known[id(document)] = document, _texts(document, watcher.stream.seldom)
        texts = known[id(document)][1]
        is_new = watcher.sent is None or texts.urgent != watcher.sent.urgent
        if not is_new and now_s - watcher.sent_s < SIGN_OF_LIFE_S:
            return
        members = texts.whole if texts != watcher.sent else ""
        watcher.sent, watcher.sent_s, watcher.busy = texts, now_s, True
        # A browser is to show how old the state is, also when a fault keeps it from being made.
        sent_ms = 1e3 * min(now_s, self.fresh_s)
        watcher.sender.write(f'data: {{{members}"sent_ms":{sent_ms:.0f}}}\n\n'.encode())
        sending = asyncio.ensure_future(watcher.sender.flush())
        sending.add_done_callback(partial(self._sent, watcher))

    def _sent(self, watcher: Watcher, sending: asyncio.Future[Any]) -> None:
        """Note that a browser has taken what was sent: a slow one gets the newest state later."""
        error = None if sending.cancelled() else sending.exception()
        if error is None:
            watcher.busy = False
            return
        watcher.gone.set()
        if not isinstance(error, StreamClosedError):
            self._report(error)


def _texts(document: Mapping[str, Any], seldom: FrozenSet[str]) -> Texts:
    members = {name: f"{json_text(name)}:{json_text(one)}," for name, one in document.items()}
    urgent = "".join(one for name, one in members.items() if name not in seldom)
    return Texts("".join(members.values()), urgent)


def json_text(value: Any) -> str:
    """Return a value as JSON, in one line."""
    return json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
