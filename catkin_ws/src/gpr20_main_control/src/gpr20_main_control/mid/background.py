"""Calls that may take long, waited for without ignoring an interruption."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from concurrent.futures import wait as wait_for_futures
from typing import Callable, TypeVar

Result = TypeVar("Result")
POLL_S = 0.05


def in_background(call: Callable[[], Result]) -> Future[Result]:
    """Begin a call in a thread of its own.

    The thread is a daemon: a call that hangs in a device outlives the survey that has given
    it up, but not the node.
    """
    future: Future[Result] = Future()

    def run() -> None:
        try:
            future.set_result(call())
        except BaseException as error:
            # Raised again where the result is asked for.
            future.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    return future


def interruptible(call: Callable[[], Result], check: Callable[[], None]) -> Result:
    """Make a call that may take long and return its result, or raise what it raised.

    Args:
        call: What to call. If the wait for it is given up, it goes on in its thread.
        check: Called again and again meanwhile; what it raises ends the wait.
    """
    return result_of(in_background(call), check)


def result_of(future: Future[Result], check: Callable[[], None]) -> Result:
    """Return the result of a call, or raise what it raised.

    Args:
        future: The call.
        check: Called again and again meanwhile; what it raises ends the wait.
    """
    while not wait_for_futures([future], POLL_S).done:
        check()
    return future.result()
