"""The event loop of the page, in a thread beside those of ROS."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from typing import Any, Awaitable, Callable, Deque

# The window refreshes as often; nobody reads figures that change faster.
REFRESH_S = 0.2
# While nobody watches.
REST_S = 1.0
STOP_LIMIT_S = 5.0


class EventLoop:
    """Handles events of any thread in one, and refreshes what is shown.

    Args:
        handle: Takes an event.
        refresh: Called after the events; returns whether anybody watches.
        report: Takes an exception of both.
    """

    def __init__(
        self,
        handle: Callable[[Any], None],
        refresh: Callable[[], bool],
        report: Callable[[BaseException], None],
    ) -> None:
        self._handle, self._refresh, self._report = handle, refresh, report
        # One call of the loop for many events: an axis reports 50 times a second.
        self._events: Deque[Any] = deque()
        self.loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="page", daemon=True)

    def put(self, event: Any) -> None:
        """Take an event, in any thread."""
        self._events.append(event)

    def begin(self) -> None:
        self._thread.start()

    def call(self, work: Callable[[], Awaitable[Any]]) -> Any:
        """Return what work returns in the thread of the loop, or raise what it raises."""

        async def run() -> Any:
            return await work()

        return asyncio.run_coroutine_threadsafe(run(), self.loop).result(STOP_LIMIT_S)

    def end(self) -> None:
        """End the thread."""
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join(STOP_LIMIT_S)

    def _run(self) -> None:
        asyncio.set_event_loop(self.loop)
        self.loop.call_soon(self._beat)
        self.loop.run_forever()

    def _beat(self) -> None:
        watched = True
        try:
            while self._events:
                self._handle(self._events.popleft())
            watched = self._refresh()
        except Exception as error:  # the next beat shows what is true then
            self._report(error)
        self.loop.call_later(REFRESH_S if watched else REST_S, self._beat)
