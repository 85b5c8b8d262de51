"""Calls at a fixed rate."""

import threading
import time

import pytest

pytest.importorskip("rospy")

from gpr20_common.high.periodic import Periodic

LIMIT_S = 100.0


class Counter:
    def __init__(self):
        self.calls_s = []
        self.called = threading.Condition()

    def __call__(self):
        with self.called:
            self.calls_s.append(time.monotonic())
            self.called.notify_all()

    def wait_for(self, calls):
        with self.called:
            assert self.called.wait_for(lambda: len(self.calls_s) >= calls, LIMIT_S)


def test_it_calls_no_faster_than_its_period_and_not_after_it_was_stopped():
    counter = Counter()
    begun_s = time.monotonic()
    periodic = Periodic(0.01, counter)
    counter.wait_for(20)
    # Delays of single calls do not add up, and calls that were missed are left out.
    assert all(one >= begun_s + 0.01 * number for number, one in enumerate(counter.calls_s))
    periodic.stop()
    calls, another = len(counter.calls_s), Counter()
    Periodic(0.01, another)
    another.wait_for(5)
    assert len(counter.calls_s) == calls


def test_it_goes_on_after_calls_that_fail_and_logs_the_first(fault_log):
    counter = Counter()

    def act():
        counter()
        raise ZeroDivisionError("a fault of our own")

    periodic = Periodic(0.001, act)
    counter.wait_for(5)
    periodic.stop()
    assert len(fault_log) == 1
