"""The one thread that writes files, and the queues in front of it."""

from __future__ import annotations

import threading
from collections import deque
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import replace
from typing import Any, Callable, Deque, Dict, List, NamedTuple, Optional, Sequence, Tuple, TypeVar

from gpr20_common.faults import DISK_SLOW, PART_SILENT
from gpr20_common.message import Message
from gpr20_survey.errors import StorageFailedError
from gpr20_survey.recording.mcap_writer import RecordedMessage

Result = TypeVar("Result")
# What a message takes beside its content.
MESSAGE_BYTES = 1000
# How often messages are written in a period.
WRITES_IN_PERIOD = 8
# Limit of one message that is kept for later recordings; a status has a thousandth of it.
LARGEST_LATCHED_BYTES = 1 << 20


class QueueState(NamedTuple):
    """How much waits for the disk, and how much did not fit."""

    jobs: int
    messages: int
    dropped: int


class _Job(NamedTuple):
    work: Callable[[], Any]
    outcome: Future


class StorageThread:
    """Does jobs one after the other and writes messages between them.

    A job is never dropped: its caller waits until it is done, so that no more wait than there are
    callers. Messages are dropped, and counted, when their queue is full. They wait for the next
    job, for more of them, or for a part of the period: writing each by itself would wake the
    thread a hundred times a second. While nothing is recorded they do not wait at all.
    """

    def __init__(
        self,
        write_messages: Callable[[Sequence[RecordedMessage]], None],
        most_bytes: int,
        period_s: float,
    ) -> None:
        """Build the thread without starting it.

        Args:
            write_messages: Writes what was offered since its last call; called several times in a
                period [s], with nothing if there was nothing. It must not raise.
            most_bytes: How large the messages that wait may be together [bytes].
            period_s: Messages are written within this time [s].
        """
        self._write_messages = write_messages
        self._most_bytes = most_bytes
        self._period_s = period_s
        self._changed = threading.Condition()  # guards all below
        self._jobs: Deque[_Job] = deque()
        self._messages: List[RecordedMessage] = []
        self._message_bytes = 0
        self._dropped = 0
        self._recording = False
        self._latched: Dict[str, RecordedMessage] = {}  # the last one of each topic
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="storage", daemon=True)

    def start(self) -> None:
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
                    "the disk did not write everything within {limit_s:g} s; check that it is "
                    "plugged in and not full",
                    limit_s=timeout_s,
                ),
                fault=DISK_SLOW,
            )

    def state(self) -> QueueState:
        """Return how full the queues are."""
        with self._changed:
            return QueueState(len(self._jobs), len(self._messages), self._dropped)

    def begin_recording(self, time_ns: int) -> List[RecordedMessage]:
        """Queue messages from now on; return the last ones of latched topics, as of now [ns]."""
        with self._changed:
            self._recording = True
            return [replace(one, time_ns=time_ns) for one in self._latched.values()]

    def end_recording(self) -> None:
        with self._changed:
            self._recording = False

    def offer(self, message: RecordedMessage) -> None:
        """Queue a message, never waiting; it is dropped if there are too many."""
        size = message.size_bytes + MESSAGE_BYTES
        with self._changed:
            if message.latching and message.size_bytes <= LARGEST_LATCHED_BYTES:
                self._latched[message.topic] = message
            if not self._recording:
                return
            if self._stopping or self._message_bytes + size > self._most_bytes:
                self._dropped += 1
                return
            self._messages.append(message)
            self._message_bytes += size
            if self._many_wait:
                self._changed.notify_all()

    def do(self, work: Callable[[], Result], timeout_s: float) -> Result:
        """Do work on the thread, after all that was queued before; return or raise what it does.

        Raises:
            StorageFailedError: The disk was too slow [s], or the thread has ended.
        """
        job = _Job(work, Future())
        with self._changed:
            if self._stopping:
                raise StorageFailedError(
                    Message("the storage is shutting down; nothing was written"),
                    fault=PART_SILENT,
                )
            self._jobs.append(job)
            self._changed.notify_all()
        try:
            return job.outcome.result(timeout_s)
        except FutureTimeoutError:
            state = Message("the write may still succeed, and repeating it is safe")
            if job.outcome.cancel():
                state = Message("nothing was written")
            raise StorageFailedError(
                Message(
                    "the disk did not finish within {limit_s:g} s; {state}; check that it is "
                    "plugged in and not full",
                    limit_s=timeout_s,
                    state=state,
                ),
                fault=DISK_SLOW,
            ) from None

    def _run(self) -> None:
        while True:
            messages, job, ended = self._next()
            self._write_messages(messages)
            if job is None and ended:
                return
            if job is not None and job.outcome.set_running_or_notify_cancel():
                try:
                    job.outcome.set_result(job.work())
                except BaseException as error:  # passed to the caller that waits
                    job.outcome.set_exception(error)

    def _next(self) -> Tuple[List[RecordedMessage], Optional[_Job], bool]:
        with self._changed:
            self._changed.wait_for(
                lambda: self._jobs or self._stopping or self._many_wait,
                self._period_s / WRITES_IN_PERIOD,
            )
            messages, self._messages, self._message_bytes = self._messages, [], 0
            job = self._jobs.popleft() if self._jobs else None
            return messages, job, self._stopping

    @property
    def _many_wait(self) -> bool:
        """Whether the queue of messages is half full."""
        return 2 * self._message_bytes >= self._most_bytes
