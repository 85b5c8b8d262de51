"""One request at a time, in a thread that lives as long as the node."""

from __future__ import annotations

import queue
import threading
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, Generic, Optional, TypeVar

from gpr20_common.faults import BUSY
from gpr20_common.message import Message
from gpr20_imaging.errors import ImagingError
from gpr20_imaging.low.cancellation import Cancellation

Result = TypeVar("Result")
MOST_WAITING = 8


@dataclass
class _Job(Generic[Result]):
    request_id: str
    work: Callable[[Cancellation], Result]
    cancellation: Cancellation = field(default_factory=Cancellation)
    ended: threading.Event = field(default_factory=threading.Event)
    result: Optional[Result] = None
    error: Optional[BaseException] = None


class JobQueue:
    """Carries out requests one after the other; each caller waits for its own.

    Args:
        prepare: Called first in the thread.
        idle: Called when there was no request for a while.
        idle_s: How long [s].
    """

    def __init__(
        self, prepare: Callable[[], None], idle: Callable[[], None], idle_s: float
    ) -> None:
        self._prepare = prepare
        self._idle = idle
        self._idle_s = idle_s
        self._lock = threading.Lock()
        self._jobs: Dict[int, _Job] = {}
        self._queue: queue.Queue[Optional[_Job]] = queue.Queue()
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name="imaging", daemon=True)
        self._thread.start()

    @property
    def waiting(self) -> int:
        """Number of requests, with the one that is carried out."""
        return len(self._jobs)

    def run(self, request_id: str, work: Callable[[Cancellation], Result]) -> Result:
        """Carry out a request, after those that came before, and return its result.

        Args:
            request_id: What `cancel` is given.
            work: Does it; called in the thread of this object.

        Raises:
            ImagingError: Too many requests wait, the request was cancelled or failed.
        """
        job: _Job[Result] = _Job(request_id, work)
        with self._lock:
            if self._is_closed or len(self._jobs) >= MOST_WAITING:
                raise ImagingError(
                    Message("Too many requests are waiting. Try again later."), fault=BUSY
                )
            self._jobs[id(job)] = job
            self._queue.put(job)
        job.ended.wait()
        if job.error is not None:
            raise job.error
        return job.result  # type: ignore[return-value]

    def cancel(self, request_id: str) -> bool:
        """End the requests of a name; return whether there was one."""
        with self._lock:
            jobs = [one for one in self._jobs.values() if one.request_id == request_id]
        for job in jobs:
            job.cancellation.cancel()
        return bool(jobs)

    def close(self) -> None:
        """Cancel every request and end the thread."""
        with self._lock:
            self._is_closed = True
            jobs = list(self._jobs.values())
        for job in jobs:
            job.cancellation.cancel()
        self._queue.put(None)
        self._thread.join()

    def _run(self) -> None:
        self._prepare()
        while True:
            try:
                job = self._queue.get(timeout=self._idle_s)
            except queue.Empty:
                self._idle()
                continue
            if job is None:
                self._idle()
                return
            self._carry_out(job)

    def _carry_out(self, job: _Job[Any]) -> None:
        try:
            job.cancellation.check()
            job.result = job.work(job.cancellation)
        except BaseException as error:
            # The caller gets it; the thread must survive.
            job.error = error
        finally:
            with self._lock:
                del self._jobs[id(job)]
            job.ended.set()
