"""A service answers with success, or with what went wrong and its code."""

import pytest
from case_kit import each_case

pytest.importorskip("rospy")

import rospy

from gpr20_common import faults
from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.high.services import advertise
from gpr20_common.message import Message
from gpr20_common.sent_message import message_from
from gpr20_msgs.srv import Command, CommandRequest, CommandResponse


@pytest.fixture
def ask(monkeypatch):
    """Return what asks a service whose handler is given."""
    monkeypatch.setattr(rospy, "Service", lambda _name, _class, handler: handler)
    return lambda handler: advertise("homing", Command, handler)(CommandRequest())


def failing(error):
    def handler(_request):
        raise error

    return handler


def test_an_answer_is_passed_on(ask):
    assert ask(lambda _request: CommandResponse(success=True)).success


@each_case("fault", [None, faults.DISK_FULL])
def test_an_error_becomes_an_answer_with_its_fault(ask, fault):
    error = InvalidValueError(Message("{axis} is refused", axis="x"), fault=fault)
    answer = ask(failing(error))
    assert not answer.success and answer.message == str(error)
    assert answer.fault_code == (fault or faults.NOT_ALLOWED).code
    assert message_from(answer).cause == (fault or faults.NOT_ALLOWED)


@each_case("error", [ZeroDivisionError("0"), KeyError("x"), OSError(5, "bad")])
def test_a_fault_in_our_own_code_is_an_answer_too(ask, error):
    assert not isinstance(error, Gpr20Error)
    answer = ask(failing(error))
    assert not answer.success and type(error).__name__ in answer.message
    assert message_from(answer).cause == faults.INTERNAL
