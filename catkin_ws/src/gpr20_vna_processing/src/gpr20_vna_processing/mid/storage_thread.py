"""The one thread that writes files, and the bounded queues in front of it."""

from __future__ import annotations

import threading
from collections import deque
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass
from typing import Any, Callable, Deque, Generic, List, Optional, Sequence, Tuple, TypeVar

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.mid.checks import positive_number
from gpr20_survey.errors import StorageFailedError
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_vna_processing import faults

Result = TypeVar("Result")
# How often messages are written in a period.
WRITES_IN_PERIOD = 8


@dataclass(frozen=True)
class QueueLimits:
    """How much may wait for the disk."""

    jobs: int = 4
    messages: int = 5000
    message_bytes: int = 16 << 20

    def __post_init__(self) -> None:
        for name in ("jobs", "messages", "message_bytes"):
            positive_number(name, getattr(self, name))


@dataclass(frozen=True)
class QueueState:
    """How much waits for the disk, and how much did not fit."""

    jobs: int
    messages: int
    dropped: int


class _Job(Generic[Result]):
    def __init__(self, work: Callable[[], Result]) -> None:
        self._work = work
        self.outcome: Future = Future()

    def execute(self) -> None:
        if not self.outcome.set_running_or_notify_cancel():
            return
        try:
            self.outcome.set_result(self._work())
        except BaseException as error:  # passed to the caller that waits
            self.outcome.set_exception(error)


class StorageThread:
    """Does jobs one after the other and writes messages between them.

    A job is never dropped: when the disk is slower than the survey, the caller with the
    next one waits. Messages are dropped, and counted, when their queue is full. They wait for
    the next job, for more of them, or for a part of the period: writing each by itself would wake
    the thread a hundred times a second.
    """

    def __init__(
        self,
        write_messages: Callable[[Sequence[RecordedMessage]], None],
        limits: QueueLimits,
        clock: Clock,
        period_s: float,
    ) -> None:
        """Build the thread without starting it.

        Args:
            write_messages: Writes what was offered since its last call; called on the
                thread several times in a period, with nothing if there was nothing. It must
                not raise.
            limits: Sizes of the queues.
            clock: For time limits.
            period_s: Messages are written within this time [s].
        """
        self._write_messages = write_messages
        self._limits = limits
        self._clock = clock
        self._period_s = period_s
        self._changed = threading.Condition()
        self._jobs: Deque[_Job] = deque()
        self._messages: Deque[RecordedMessage] = deque()
        self._message_bytes = 0
        self._dropped = 0
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="storage", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self, timeout_s: float) -> None:
        """Do what waits, end the thread and return when it has ended.

        Raises:
            StorageFailedError: It did not end within the time limit [s].
        """
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
        self._thread.join(timeout_s)
        if self._thread.is_alive():
            raise StorageFailedError(
                Message(
                    "the disk did not write everything within {limit_s:g} s; check the disk",
                    limit_s=timeout_s,
                ),
                fault=faults.DISK_SLOW,
            )

    def state(self) -> QueueState:
        """Return how full the queues are."""
        with self._changed:
            return QueueState(len(self._jobs), len(self._messages), self._dropped)

    def offer(self, message: RecordedMessage) -> bool:
        """Queue a message, never waiting; return False if it was dropped."""
        size = message.size_bytes
        with self._changed:
            fits = (
                len(self._messages) < self._limits.messages
                and self._message_bytes + size <= self._limits.message_bytes
                and not self._stopping
            )
            if not fits:
                self._dropped += 1
                return False
            self._messages.append(message)
            self._message_bytes += size
            if self._many_wait:
                self._changed.notify_all()
        return True

    def do(self, work: Callable[[], Result], timeout_s: float) -> Result:
        """Do work on the thread, after all that was queued before, and return its result.

        Args:
            work: What to do; what it raises is raised here.
            timeout_s: Time limit for waiting in the queue and for the work [s].

        Raises:
            StorageFailedError: The disk was too slow, or the thread has ended.
        """
        deadline_s = self._clock.now_s() + timeout_s
        job = _Job(work)
        self._enqueue(job, deadline_s, timeout_s)
        try:
            return job.outcome.result(max(0.0, deadline_s - self._clock.now_s()))
        except FutureTimeoutError:
            if job.outcome.cancel():
                state = Message("nothing was written")
            else:
                state = Message("the write may still succeed, and repeating it is safe")
            raise StorageFailedError(
                Message(
                    "the disk did not finish within {limit_s:g} s; {state}; check the disk",
                    limit_s=timeout_s,
                    state=state,
                ),
                fault=faults.DISK_SLOW,
            ) from None

    def _enqueue(self, job: _Job, deadline_s: float, timeout_s: float) -> None:
        with self._changed:
            while len(self._jobs) >= self._limits.jobs and not self._stopping:
                remaining_s = deadline_s - self._clock.now_s()
                if remaining_s <= 0.0:
                    raise StorageFailedError(
                        Message(
                            "the disk was not free within {limit_s:g} s, with {count} earlier "
                            "requests waiting; nothing was written; check the disk",
                            limit_s=timeout_s,
                            count=len(self._jobs),
                        ),
                        fault=faults.DISK_SLOW,
                    )
                self._changed.wait(remaining_s)
            if self._stopping:
                raise StorageFailedError(
                    Message("the storage is shutting down; nothing was written"),
                    fault=faults.SHUTTING_DOWN,
                )
            self._jobs.append(job)
            self._changed.notify_all()

    def _run(self) -> None:
        while True:
            messages, job, ended = self._next()
            self._write_messages(messages)
            if job is not None:
                job.execute()
            elif ended:
                return

    def _next(self) -> Tuple[List[RecordedMessage], Optional[_Job[Any]], bool]:
        with self._changed:
            self._changed.wait_for(
                lambda: self._jobs or self._stopping or self._many_wait,
                self._period_s / WRITES_IN_PERIOD,
            )
            messages = list(self._messages)
            self._messages.clear()
            self._message_bytes = 0
            job = self._jobs.popleft() if self._jobs else None
            self._changed.notify_all()
            return messages, job, self._stopping

    @property
    def _many_wait(self) -> bool:
        """Whether the queue of messages is half full."""
        return (
            2 * len(self._messages) >= self._limits.messages
            or 2 * self._message_bytes >= self._limits.message_bytes
        )
