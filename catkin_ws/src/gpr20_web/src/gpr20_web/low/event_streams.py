"""Server-sent events: to each browser its document when it changes, no faster than it reads."""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import time
from typing import Any, AsyncIterator, Callable, Iterator, List, Optional, Set

from gpr20_common.message import Message
from gpr20_web.calls import Document, Person
from gpr20_web.faults import BAD_REQUEST, BusyError

MAX_STREAMS = 64
# A browser has six connections to one computer for all its pages: STOP needs one.
MAX_STREAMS_OF_SESSION = 3
# Without a change that matters at once; a browser shows what it has as old after 5 s.
SIGN_OF_LIFE_S = 1.0
# How often a stream asks whether its person may still watch.
SESSION_CHECK_S = 5.0


class EventStreams:
    """All browsers that watch; belongs to the thread of the event loop.

    Args:
        check: Raises NotLoggedInError if the person of a session may no longer watch.
    """

    def __init__(self, check: Callable[[Person], object]) -> None:
        self._check = check
        self._people: List[Person] = []
        self._waiting: Set[asyncio.Future[None]] = set()
        self._made_s, self._ended = time.monotonic(), False

    def __len__(self) -> int:
        return len(self._people)

    def has(self, session: str) -> bool:
        """Return whether a browser of a session watches now."""
        return any(one.session == session for one in self._people)

    def beat(self) -> None:
        """Send what was made just now.

        Without beats nothing is sent, and browsers show how old what they have is.
        """
        self._made_s = time.monotonic()
        waiting, self._waiting = self._waiting, set()
        for one in waiting:
            if not one.done():
                one.set_result(None)

    def end(self) -> None:
        """End every stream."""
        self._ended = True
        self.beat()

    @contextlib.contextmanager
    def watching(self, person: Person) -> Iterator[None]:
        """Count a browser of a person inside.

        Raises:
            BusyError: There are too many.
        """
        own = [one for one in self._people if one.session == person.session]
        if len(self) >= MAX_STREAMS or len(own) >= MAX_STREAMS_OF_SESSION:
            raise BusyError(
                Message(
                    "too many pages are open (at most {one} in one browser, {most} in all); close "
                    "one",
                    one=MAX_STREAMS_OF_SESSION,
                    most=MAX_STREAMS,
                ),
                fault=BAD_REQUEST,
            )
        self._people.append(person)
        try:
            yield
        finally:
            self._people.remove(person)

    async def events(self, make: Callable[[], Document], person: Person) -> AsyncIterator[bytes]:
        """Yield what is sent to a browser; whoever is slow gets the newest state next.

        Raises:
            NotLoggedInError: The person may no longer watch.
        """
        sent: Optional[Document] = None
        sent_s, checked_s = -math.inf, time.monotonic()
        while not self._ended:
            now_s = time.monotonic()
            if now_s - checked_s > SESSION_CHECK_S:
                checked_s = now_s
                self._check(person)
            document = make()
            is_new = sent is None or document.urgent != sent.urgent
            if is_new or now_s - sent_s >= SIGN_OF_LIFE_S:
                members = "" if document == sent else "".join(document)
                sent, sent_s = document, now_s
                yield f'data: {{{members}"sent_ms":{1e3 * self._made_s:.0f}}}\n\n'.encode()
            beat: asyncio.Future[Any] = asyncio.get_event_loop().create_future()
            self._waiting.add(beat)
            await beat


def json_text(value: Any) -> str:
    """Return a value as JSON, in one line."""
    return json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
