"""Calls that may take long, in waits that can be interrupted."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from concurrent.futures import wait as wait_for_futures
from typing import Callable, Optional, TypeVar

Result = TypeVar("Result")
POLL_S = 0.05


class SerialCalls:
    """Calls of one device, made one at a time.

    A call that was given up may still wait for a node that is being restarted, and would undo
    there what later calls requested. So the next call waits for its end, and a call that is given
    up while it waits for its turn is never made.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()

    def call(self, call: Callable[[], Result], check: Callable[[], None]) -> Result:
        """Make a call when those before it have ended, and return its result.

        Args:
            call: What to call. If the wait for it is given up once it has begun, it continues
                in its thread.
            check: Called repeatedly meanwhile; an error that it raises ends the wait.
        """
        return result_of(in_background(call, self._lock), check)


def in_background(
    call: Callable[[], Result], turn: Optional[threading.Lock] = None
) -> Future[Result]:
    """Begin a call in a thread of its own.

    The thread is a daemon: a call that hangs in a device outlives the survey that gave it up,
    but not the node.

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
            # Raised again by `result_of`.
            future.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return future


def result_of(future: Future[Result], check: Callable[[], None]) -> Result:
    """Return the result of a call, or raise what it raised.

    Args:
        future: The call.
        check: Called repeatedly meanwhile; an error that it raises ends the wait.
    """
    try:
        while not wait_for_futures([future], POLL_S).done:
            check()
    finally:
        future.cancel()  # a call that has begun continues
    return future.result()
