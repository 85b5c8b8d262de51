"""The one thread that writes: bounded queues, in order, and nothing done that was given up."""

from __future__ import annotations

import threading

import pytest
from fault_kit import raises_fault
from storage_kit import text_message
from wait_kit import wait_until

from gpr20_survey.errors import StorageFailedError
from gpr20_vna_processing.mid.storage_thread import MESSAGE_BYTES, StorageThread

TIME_LIMIT_S = 100.0


class Disk:
    """A disk that takes nothing while it is blocked."""

    def __init__(self, period_s: float = 0.05, messages: int = 1000) -> None:
        self.written = []
        self.writes = []
        self.busy = threading.Event()
        self.released = threading.Event()
        self.threads = []
        size = text_message("/t", "a").size_bytes + MESSAGE_BYTES
        self.thread = StorageThread(self.write, messages * size, period_s)
        self.thread.begin_recording(1)
        self.thread.start()

    def write(self, messages) -> None:
        self.written.extend(messages)
        self.writes.append(len(messages))

    def hang(self) -> None:
        self.busy.set()
        self.released.wait(TIME_LIMIT_S)

    def do_later(self, job) -> None:
        self.threads.append(threading.Thread(target=self.thread.do, args=(job, TIME_LIMIT_S)))
        self.threads[-1].start()

    def block(self) -> None:
        self.do_later(self.hang)
        assert self.busy.wait(TIME_LIMIT_S)

    def release(self) -> None:
        self.released.set()
        for thread in self.threads:
            thread.join(TIME_LIMIT_S)

    def offer(self, *texts: str) -> int:
        """Return how many of all messages were dropped so far."""
        for text in texts:
            self.thread.offer(text_message("/t", text))
        return self.thread.state().dropped


@pytest.fixture
def disks():
    """Makes disks, and stops their threads."""
    made = []

    def make(**options):
        made.append(Disk(**options))
        return made[-1]

    yield make
    for disk in made:
        disk.release()
        disk.thread.stop(TIME_LIMIT_S)


def test_messages_beyond_the_queue_are_dropped_and_counted(disks):
    disk = disks(messages=3)
    disk.block()
    assert disk.offer(*"abcde") == 2
    disk.release()
    disk.thread.stop(TIME_LIMIT_S)
    assert len(disk.written) == 3
    disk = disks(messages=1)
    disk.block()
    assert disk.offer("x" * 2, "x") == 1


def test_messages_are_written_before_the_job_that_came_after_them(disks):
    disk, seen = disks(), []
    disk.block()
    disk.offer("before")
    disk.do_later(lambda: seen.extend(disk.written))
    disk.release()
    assert len(seen) == 1


def test_messages_are_written_many_at_a_time_and_at_once_if_half_of_the_queue_is_full(disks):
    disk = disks()
    disk.block()
    disk.offer(*map(str, range(100)))
    disk.release()
    wait_until(lambda: len(disk.written) == 100)
    assert len([one for one in disk.writes if one]) <= 3
    disk = disks(period_s=1000.0, messages=10)
    assert disk.offer(*"abcde") == 0
    wait_until(lambda: len(disk.written) == 5)


def test_every_job_is_done_in_its_order_however_many_wait(disks):
    disk, done = disks(), []
    disk.block()
    for number in range(20):
        disk.do_later(lambda number=number: done.append(number))
        wait_until(lambda number=number: disk.thread.state().jobs == number + 1)
    disk.release()
    assert done == list(range(20)) and disk.thread.state().jobs == 0


def test_a_job_that_was_given_up_is_not_done_later(disks):
    disk, done = disks(), []
    disk.block()
    with raises_fault("disk.slow", error=StorageFailedError):
        disk.thread.do(lambda: done.append(1), 0.05)
    disk.release()
    disk.thread.stop(TIME_LIMIT_S)
    assert done == []


def test_stopping_does_what_waits_and_refuses_what_comes(disks):
    disk = disks()
    disk.offer("last")
    disk.thread.stop(TIME_LIMIT_S)
    assert len(disk.written) == 1
    with raises_fault("robot.part_silent", error=StorageFailedError):
        disk.thread.do(lambda: 1, TIME_LIMIT_S)
    assert disk.offer("too late") == 1
