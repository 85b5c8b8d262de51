"""Storing in the background: the next move does not wait for the disk."""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import Callable, Deque, Optional

from gpr20_common.faults import DISK_REFUSES
from gpr20_common.low.clock import Clock
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError, message_of
from gpr20_main_control.mid.devices.robot import Storage
from gpr20_main_control.mid.waits import Check
from gpr20_survey.trace.trace import Trace

# Traces that may wait for the disk; if there are more, the survey waits.
CAPACITY = 4
ATTEMPTS = 3
RETRY_S = 1.0
POLL_S = 0.1


class StorageQueue:
    """Stores traces one after another in a thread of its own.

    A trace leaves the queue only when it is stored durably. After a failure all traces stay in
    the queue until `retry` is called.
    """

    def __init__(
        self, storage: Storage, clock: Clock, on_stored: Callable[[int, int], None]
    ) -> None:
        """Start the thread.

        `on_stored` is called with the number of traces stored so far and the index of the last.
        """
        self._storage = storage
        self._clock = clock
        self._on_stored = on_stored
        self._changed = threading.Condition()
        self._traces: Deque[Trace] = deque()
        self._stored = 0
        self._failure: Optional[Exception] = None
        self._retries = 0
        self._closing = threading.Event()
        threading.Thread(target=self._work, name="storage queue", daemon=True).start()

    @property
    def waiting(self) -> int:
        """Number of traces that are not stored durably yet."""
        return len(self._traces)

    def add(self, trace: Trace) -> None:
        """Accept a trace; it will be stored whatever the survey does next."""
        with self._changed:
            self._traces.append(trace)
            self._changed.notify_all()

    def wait_until_left(self, traces: int, check: Check) -> None:
        """Return when at most so many traces wait for the disk; `check` may end the wait.

        Raises:
            DeviceError: Storing has failed; the traces wait for `retry`.
        """
        with self._changed:
            while len(self._traces) > traces and self._failure is None:
                check()
                self._changed.wait(POLL_S)
            if self._failure is not None:
                raise DeviceError(
                    Message(
                        "trace {index} could not be stored: {reason}",
                        index=self._traces[0].index,
                        reason=message_of(self._failure),
                    ),
                    fault=DISK_REFUSES,
                ) from self._failure

    def drain_within(self, time_limit_s: float) -> None:
        """Return when every trace is stored durably.

        Raises:
            DeviceError: Storing has failed, or it takes longer than the limit [s].
        """
        deadline_s = time.monotonic() + time_limit_s

        def check() -> None:
            if time.monotonic() > deadline_s:
                raise DeviceError(
                    Message(
                        "{count} traces were not stored within {limit_s:g} s; check the disk and "
                        "the storage",
                        count=len(self._traces),
                        limit_s=time_limit_s,
                    ),
                    fault=DISK_REFUSES,
                )

        self.wait_until_left(0, check)

    def retry(self) -> None:
        """Clear a failure and try again with the trace that failed."""
        with self._changed:
            self._failure = None
            self._retries += 1
            self._changed.notify_all()

    def close(self) -> None:
        """End the thread; traces that are not stored yet are dropped."""
        self._closing.set()
        with self._changed:
            self._changed.notify_all()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(
                    lambda: self._closing.is_set() or (self._traces and self._failure is None)
                )
                if self._closing.is_set():
                    return
                trace, retries = self._traces[0], self._retries
            failure = self._store(trace)
            if self._closing.is_set():
                # The queue is closed, and another survey may have begun.
                return
            if failure is None:
                self._stored += 1
                # Announced before the trace leaves: an empty queue means that all are announced.
                # Whatever fails here, the trace is stored and must not be sent again. Without it in
                # the coverage the survey does not end as complete, and can be resumed.
                with faults_logged("storage queue"):
                    self._on_stored(self._stored, trace.index)
            with self._changed:
                if failure is None:
                    self._traces.popleft()
                elif retries == self._retries:
                    self._failure = failure
                self._changed.notify_all()

    def _store(self, trace: Trace) -> Optional[Exception]:
        failure: Optional[Exception] = None
        for _attempt in range(ATTEMPTS):
            try:
                self._storage.store(trace)
                return None
            except Exception as error:
                # Faults in the software too: they must not leave the survey waiting for ever.
                failure = error
            if self._clock.wait_s(self._closing, RETRY_S):
                break
        return failure
