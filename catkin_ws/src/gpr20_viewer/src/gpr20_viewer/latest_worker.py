"""A thread that computes the latest request only."""

from __future__ import annotations

import threading
from typing import Callable, Generic, Iterable, Optional, TypeVar

Request = TypeVar("Request")
Result = TypeVar("Result")


class Closed(Exception):
    """The worker was closed, so a computation in progress ends."""


class LatestWorker(Generic[Request, Result]):
    """Computes requests one after the other; one that a later one replaced is never begun.

    Args:
        compute: Returns the result of a request; it passes what it loops over through the
            function that it gets, so that it ends soon when the worker is closed.
        deliver: Takes each request with its result, in the worker's thread.
        failed: Takes each request with the error that its computation raised, in that thread.
    """

    def __init__(
        self,
        compute: Callable[[Request, Callable[..., Iterable]], Result],
        deliver: Callable[[Request, Result], None],
        failed: Callable[[Request, Exception], None],
    ) -> None:
        self._compute = compute
        self._deliver = deliver
        self._failed = failed
        self._changed = threading.Condition()
        self._next: Optional[Request] = None
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name="latest worker")
        self._thread.start()

    def request(self, wanted: Request) -> None:
        """Compute this next, in place of a request that is still waiting."""
        with self._changed:
            self._next = wanted
            self._changed.notify()

    def close(self) -> None:
        """End the thread; return when nothing more will be delivered."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._is_closed or self._next is not None)
                if self._is_closed:
                    return
                wanted, self._next = self._next, None
            assert wanted is not None
            try:
                result = self._compute(wanted, self._until_closed)
            except Closed:
                return
            # The thread must survive: the window shows the error and asks for something else.
            except Exception as error:
                if not self._is_closed:
                    self._failed(wanted, error)
            else:
                if not self._is_closed:
                    self._deliver(wanted, result)

    def _until_closed(self, items: Iterable, total: Optional[int] = None) -> Iterable:
        for item in items:
            if self._is_closed:
                raise Closed
            yield item
