from __future__ import annotations

import threading

import pytest
from fault_kit import raises_fault
from storage_kit import text_message, wait_until

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.errors import StorageFailedError, TraceRefusedError
from gpr20_vna_processing.mid.storage_thread import QueueLimits, StorageThread

TIME_LIMIT_S = 10.0


class Disk:
    """A disk that takes nothing until it is released."""

    def __init__(self, **limits: int) -> None:
        self.written = []
        self.busy = threading.Event()
        self.released = threading.Event()
        self.thread = StorageThread(
            self.written.extend, QueueLimits(**limits), Clock(), period_s=0.05
        )
        self.thread.start()

    def hang(self) -> None:
        self.busy.set()
        self.released.wait(TIME_LIMIT_S)

    def block(self) -> threading.Thread:
        caller = threading.Thread(target=lambda: self.thread.do(self.hang, TIME_LIMIT_S))
        caller.start()
        assert self.busy.wait(TIME_LIMIT_S)
        return caller


def test_a_job_returns_its_result_and_raises_its_error():
    disk = Disk()

    def refuse():
        raise TraceRefusedError(Message("no"))

    assert disk.thread.do(lambda: 7, TIME_LIMIT_S) == 7
    with pytest.raises(TraceRefusedError, match="no"):
        disk.thread.do(refuse, TIME_LIMIT_S)
    disk.thread.stop(TIME_LIMIT_S)


def test_messages_beyond_the_queue_are_dropped_and_counted():
    disk = Disk(messages=3)
    caller = disk.block()
    answers = [disk.thread.offer(text_message("/t", str(n))) for n in range(5)]
    assert answers == [True, True, True, False, False]
    assert disk.thread.state().dropped == 2
    disk.released.set()
    caller.join(TIME_LIMIT_S)
    disk.thread.stop(TIME_LIMIT_S)
    assert len(disk.written) == 3


def test_messages_waiting_are_bounded_in_bytes_too():
    disk = Disk(message_bytes=100)
    caller = disk.block()
    assert not disk.thread.offer(text_message("/t", "x" * 100))
    assert disk.thread.offer(text_message("/t", "x" * 50))
    disk.released.set()
    caller.join(TIME_LIMIT_S)
    disk.thread.stop(TIME_LIMIT_S)


def test_messages_are_written_before_the_job_that_came_after_them():
    disk = Disk()
    caller = disk.block()
    disk.thread.offer(text_message("/t", "before"))
    seen = []
    later = threading.Thread(
        target=lambda: disk.thread.do(lambda: seen.extend(disk.written), TIME_LIMIT_S)
    )
    later.start()
    disk.released.set()
    for thread in (caller, later):
        thread.join(TIME_LIMIT_S)
    assert len(seen) == 1
    disk.thread.stop(TIME_LIMIT_S)


def test_messages_are_written_many_at_a_time_and_within_the_period():
    writes = []
    thread = StorageThread(
        lambda messages: writes.append(len(messages)), QueueLimits(), Clock(), period_s=1.0
    )
    thread.start()
    for number in range(100):
        thread.offer(text_message("/t", str(number)))
    wait_until(lambda: sum(writes) == 100)
    thread.stop(TIME_LIMIT_S)
    assert len([one for one in writes if one]) <= 3


def test_messages_that_fill_half_of_the_queue_are_written_at_once():
    written = []
    thread = StorageThread(written.extend, QueueLimits(messages=10), Clock(), period_s=1000.0)
    thread.start()
    for number in range(5):
        assert thread.offer(text_message("/t", str(number)))
    wait_until(lambda: len(written) == 5)
    thread.stop(TIME_LIMIT_S)


def test_a_full_queue_of_jobs_makes_the_caller_wait_and_then_says_so():
    disk = Disk(jobs=1)
    callers = [disk.block()]
    callers.append(threading.Thread(target=lambda: disk.thread.do(lambda: 1, TIME_LIMIT_S)))
    callers[1].start()
    wait_until(lambda: disk.thread.state().jobs == 1)
    with raises_fault("disk.slow", 1, error=StorageFailedError):
        disk.thread.do(lambda: 2, 0.1)
    disk.released.set()
    for thread in callers:
        thread.join(TIME_LIMIT_S)
    assert disk.thread.do(lambda: 3, TIME_LIMIT_S) == 3
    disk.thread.stop(TIME_LIMIT_S)


def test_a_job_that_was_given_up_is_not_done_later():
    disk = Disk()
    caller = disk.block()
    done = []
    with raises_fault("disk.slow", error=StorageFailedError):
        disk.thread.do(lambda: done.append(1), 0.05)
    disk.released.set()
    caller.join(TIME_LIMIT_S)
    disk.thread.stop(TIME_LIMIT_S)
    assert done == []


def test_stopping_does_what_waits_and_refuses_what_comes():
    disk = Disk()
    disk.thread.offer(text_message("/t", "last"))
    disk.thread.stop(TIME_LIMIT_S)
    assert len(disk.written) == 1
    with raises_fault("storage.shutting_down", error=StorageFailedError):
        disk.thread.do(lambda: 1, TIME_LIMIT_S)
    assert not disk.thread.offer(text_message("/t", "too late"))
