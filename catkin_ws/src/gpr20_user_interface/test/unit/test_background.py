"""Work beside the window goes on after an exception that nobody expected, and says it."""

import threading

import pytest

pytest.importorskip("rospy")

from gpr20_operator.files.newest import Newest
from gpr20_operator.high import ros_events

LIMIT_S = 10.0


@pytest.fixture
def ended(monkeypatch):
    """What threads have ended with."""
    found = []
    monkeypatch.setattr(threading, "excepthook", found.append)
    return found


def test_the_next_value_is_taken_after_one_that_failed(ended, fault_log):
    taken = []

    def act(value):
        taken.append(value)
        raise ZeroDivisionError("a fault of our own")

    newest = Newest(act)
    for value in (1, 2):
        newest.put(value)
        assert newest.wait(LIMIT_S)
    assert taken == [1, 2]
    assert ended == []
    assert len(fault_log) == 2


def test_a_request_that_fails_in_the_background_is_logged(ended, fault_log):
    threads = []

    def work():
        threads.append(threading.current_thread())
        raise ZeroDivisionError("a fault of our own")

    before = set(threading.enumerate())
    ros_events.in_background(work)
    for thread in set(threading.enumerate()) - before:
        thread.join(LIMIT_S)
    assert len(threads) == 1
    assert ended == []
    assert "a fault of our own" in "".join(fault_log)
