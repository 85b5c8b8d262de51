"""Calls at a fixed rate."""

import threading
import time

import pytest

pytest.importorskip("rospy")

import rospy

from gpr20_common.high.periodic import Periodic

LIMIT_S = 30.0


@pytest.fixture(autouse=True)
def running_node(monkeypatch):
    """A node that is not shut down: an earlier test of the same process may have ended its own."""
    monkeypatch.setattr(rospy, "on_shutdown", lambda _hook: None)


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
    periodic = Periodic(0.01, counter)
    counter.wait_for(20)
    periodic.stop()
    # Delays of single calls do not add up, and calls that were missed are left out.
    assert counter.calls_s[19] - counter.calls_s[0] >= 19 * 0.01 - 0.005
    calls = len(counter.calls_s)
    assert not threading.Event().wait(0.03)
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
