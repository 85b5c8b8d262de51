"""Threads that make calls which may take long."""

from __future__ import annotations

import queue
import threading
from concurrent.futures import Future
from concurrent.futures import wait as wait_for_futures
from typing import Any, Callable, Optional, Tuple, TypeVar

Result = TypeVar("Result")
POLL_S = 0.05


class Workers:
    """Threads that are kept for the next call; there are as many as calls at the same time.

    The threads are daemons: a call that hangs in a device outlives the survey that gave it up,
    but not the node.
    """

    def __init__(self, most: Optional[int] = None) -> None:
        """Start no thread yet.

        Args:
            most: How many calls may be made at the same time; None for any number. Others wait.
        """
        self._most = most
        self._lock = threading.Lock()
        self._threads = 0
        self._unfinished = 0
        self._calls: queue.SimpleQueue[Tuple[Future[Any], Callable[[], Any]]] = queue.SimpleQueue()

    def begin(self, call: Callable[[], Result]) -> Future[Result]:
        """Begin a call and return at once."""
        future: Future[Result] = Future()
        with self._lock:
            needed = self._unfinished >= self._threads
            if needed and (self._most is None or self._threads < self._most):
                threading.Thread(target=self._work, name="worker", daemon=True).start()
                # Counted when it runs: the system may have refused it.
                self._threads += 1
            self._unfinished += 1
        self._calls.put((future, call))
        return future

    def _work(self) -> None:
        while True:
            self._make(*self._calls.get())

    def _make(self, future: Future[Result], call: Callable[[], Result]) -> None:
        result: Optional[Result] = None
        failure: Optional[BaseException] = None
        begun = future.set_running_or_notify_cancel()
        if begun:
            try:
                result = call()
            except BaseException as error:
                # Raised again by `result_of`.
                failure = error
        # Before the result: who waits for it may begin the next call, which needs no new thread.
        with self._lock:
            self._unfinished -= 1
        if failure is not None:
            future.set_exception(failure)
        elif begun:
            future.set_result(result)  # type: ignore[arg-type]


class SerialCalls:
    """Calls of one device, made one at a time.

    A call that was given up may still wait for a node that is being restarted, and would undo
    there what later calls requested. So the next call waits for its end, and a call that is given
    up while it waits for its turn is never made.
    """

    def __init__(self) -> None:
        self._worker = Workers(most=1)

    def call(self, call: Callable[[], Result], check: Callable[[], None]) -> Result:
        """Make a call when those before it have ended, and return its result.

        Args:
            call: What to call. If the wait for it is given up once it has begun, it continues
                in its thread.
            check: Called repeatedly meanwhile; an error that it raises ends the wait.
        """
        return result_of(self._worker.begin(call), check)

    def begin(self, call: Callable[[], object]) -> None:
        """Begin a call whose result nobody needs when those before it have ended."""
        self._worker.begin(call)


def wait_for(future: Future[Result], check: Callable[[], None]) -> None:
    """Return as soon as a call has ended.

    Args:
        future: The call.
        check: Called repeatedly meanwhile; an error that it raises ends the wait.
    """
    while not wait_for_futures([future], POLL_S).done:
        check()


def result_of(future: Future[Result], check: Callable[[], None]) -> Result:
    """Return the result of a call, or raise what it raised.

    Args:
        future: The call. If the wait for it is given up before it has begun, it is never made.
        check: Called repeatedly meanwhile; an error that it raises ends the wait.
    """
    try:
        wait_for(future, check)
    finally:
        future.cancel()  # a call that has begun continues
    return future.result()
