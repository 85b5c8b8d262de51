"""Calls that may take long, waited for without ignoring an interruption."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from concurrent.futures import wait as wait_for_futures
from typing import Callable, Optional, TypeVar

Result = TypeVar("Result")
POLL_S = 0.05


class SerialCalls:
    """Calls of one device, which are never made two at a time.

    A call that was given up may still wait for a node that is being started again, and would
    undo there what was asked since. So the next one waits for its end, and what was given up
    while it waited for its turn is not made at all.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()

    def call(self, call: Callable[[], Result], check: Callable[[], None]) -> Result:
        """Make a call when those before it have ended, and return its result.

        Args:
            call: What to call. If the wait for it is given up once it has begun, it continues
                in its thread.
            check: Called again and again meanwhile; what it raises ends the wait.
        """
        return result_of(in_background(call, self._lock), check)


def in_background(
    call: Callable[[], Result], turn: Optional[threading.Lock] = None
) -> Future[Result]:
    """Begin a call in a thread of its own.

    The thread is a daemon: a call that hangs in a device outlives the survey that has given
    it up, but not the node.

    Args:
        call: What to call.
        turn: Held during the call.
    """
    future: Future[Result] = Future()

    def run() -> None:
        with turn or threading.Lock():
            if future.set_running_or_notify_cancel():
                make()

    def make() -> None:
        try:
            future.set_result(call())
        except BaseException as error:
            # Raised again where the result is asked for.
            future.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return future


def result_of(future: Future[Result], check: Callable[[], None]) -> Result:
    """Return the result of a call, or raise what it raised.

    Args:
        future: The call.
        check: Called again and again meanwhile; what it raises ends the wait.
    """
    try:
        while not wait_for_futures([future], POLL_S).done:
            check()
    finally:
        future.cancel()  # what has begun continues
    return future.result()
