"""Threads for calls: kept, as many as needed, never more than allowed."""

import threading

import pytest

from gpr20_common.message import Message
from gpr20_main_control.errors import StopRequested
from gpr20_main_control.mid.waits import Workers

LIMIT_S = 30.0


def go_on():
    pass


def give_up():
    raise StopRequested(Message("a stop was requested"))


class Hanging:
    """A call that hangs until it is released."""

    def __init__(self):
        self.begun, self.released = threading.Event(), threading.Event()

    def __call__(self):
        self.begun.set()
        return self.released.wait(LIMIT_S)


def test_a_call_that_hangs_does_not_delay_others():
    workers, hang = Workers(), Hanging()
    hanging = [workers.begin(hang) for _call in range(5)]
    assert workers.begin(lambda: 7).result(LIMIT_S) == 7
    hang.released.set()
    assert all(one.result(LIMIT_S) for one in hanging)


def test_a_call_that_was_given_up_before_its_turn_is_never_made():
    call = Workers(most=1).call
    hang, made = Hanging(), []
    first = threading.Thread(target=call, args=(hang, go_on))
    first.start()
    assert hang.begun.wait(LIMIT_S)
    with pytest.raises(StopRequested):
        call(lambda: made.append(1), give_up)
    hang.released.set()
    call(go_on, go_on)
    first.join(LIMIT_S)
    assert made == []
