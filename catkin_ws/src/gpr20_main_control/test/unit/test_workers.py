"""Threads for calls: kept, as many as needed, never more than allowed."""

import threading
import time

import pytest

from gpr20_common.message import Message
from gpr20_main_control.errors import StopRequested
from gpr20_main_control.mid.waits import SerialCalls, Workers, result_of

LIMIT_S = 10.0


def test_calls_one_after_another_share_a_thread():
    workers = Workers()
    threads = {result_of(workers.begin(threading.get_ident), lambda: None) for _call in range(50)}
    assert len(threads) == 1


def test_a_call_that_hangs_does_not_delay_others():
    workers, hang = Workers(), threading.Event()
    hanging = [workers.begin(lambda: hang.wait(LIMIT_S)) for _call in range(5)]
    assert workers.begin(lambda: 7).result(LIMIT_S) == 7
    hang.set()
    assert all(one.result(LIMIT_S) for one in hanging)


def test_no_more_calls_are_made_at_the_same_time_than_allowed():
    workers, at_work, most = Workers(most=2), [], []
    lock = threading.Lock()

    def work():
        with lock:
            at_work.append(1)
            most.append(len(at_work))
        threading.Event().wait(0.001)
        with lock:
            at_work.pop()

    for future in [workers.begin(work) for _call in range(40)]:
        future.result(LIMIT_S)
    assert max(most) <= 2 and len(most) == 40


def test_what_a_call_raises_is_raised_where_its_result_is_taken():
    def fail():
        raise ZeroDivisionError("a fault of ours")

    workers = Workers()
    with pytest.raises(ZeroDivisionError, match="a fault of ours"):
        result_of(workers.begin(fail), lambda: None)
    assert result_of(workers.begin(lambda: 1), lambda: None) == 1


def test_a_wait_ends_when_its_check_fails_and_a_call_that_has_not_begun_is_never_made():
    workers, begun, hang, made = Workers(most=1), threading.Event(), threading.Event(), []
    workers.begin(lambda: (begun.set(), hang.wait(LIMIT_S)))
    assert begun.wait(LIMIT_S)

    def stop():
        raise StopRequested(Message("a stop was requested"))

    with pytest.raises(StopRequested):
        result_of(workers.begin(lambda: made.append(1)), stop)
    hang.set()
    workers.begin(lambda: None).result(LIMIT_S)
    assert made == []


def test_a_thread_that_the_system_refuses_is_made_for_the_next_call(monkeypatch):
    calls = SerialCalls()

    def refuse(_thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", refuse)
        with pytest.raises(RuntimeError):
            calls.call(lambda: 1, lambda: None)
    deadline_s = time.monotonic() + 5.0

    def check() -> None:
        assert time.monotonic() < deadline_s, "the call is never made"

    assert calls.call(lambda: 2, check) == 2
