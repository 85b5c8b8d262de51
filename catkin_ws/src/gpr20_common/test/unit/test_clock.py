"""The clock."""

import threading
import time

from gpr20_common.low.clock import Clock


def test_a_sleep_ends_no_earlier_than_its_deadline():
    clock = Clock()
    deadline_s = clock.now_s() + 0.02
    clock.sleep_until_s(deadline_s)
    assert clock.now_s() >= deadline_s


def test_a_deadline_in_the_past_is_no_sleep():
    clock = Clock()
    clock.sleep_until_s(clock.now_s() - 1000.0)


def test_a_wait_ends_with_its_event_or_its_time_limit():
    event = threading.Event()
    begin_s = time.monotonic()
    assert not Clock().wait_s(event, 0.02)
    assert time.monotonic() - begin_s >= 0.02
    threading.Timer(0.01, event.set).start()
    assert Clock().wait_s(event, 60.0)
