"""What the client of the main control asks for, with services that answer when the test lets them.

Without a ROS master: no topic and no real service.
"""

import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from gpr20_operator.high.control_client import WITHDRAWN, ControlClient
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.events import Answer, Request
from gpr20_operator.robot.senders import Senders

LIMIT_S = 20.0


class SlowService:
    """Answers when it may, and notes that it was called."""

    def __init__(self, **answer):
        self.called, self.may_answer = threading.Event(), threading.Event()
        self._answer = SimpleNamespace(message="", message_json="", fault_code="", **answer)

    def call(self, _timeout_s, **fields):
        self.fields = fields
        self.called.set()
        assert self.may_answer.wait(LIMIT_S)
        return self._answer


@pytest.fixture
def client():
    events, answered = [], threading.Event()

    def take(event):
        events.append(event)
        if isinstance(event, Answer) and event.request is Request.START:
            answered.set()

    made = ControlClient(take, Senders("/"))
    estimated = SimpleNamespace(to_sec=lambda: 1.0)
    plan = {"plan_id": "0123", "total_points": 4, "estimated_time": estimated}
    made._set_parameters = SlowService(success=True, **plan)
    made._start = SlowService(success=True, survey_id="s")
    made._start.may_answer.set()
    made._stop = SimpleNamespace(press=lambda: None, forget=lambda: None)
    made.taken, made.answered = events, answered
    return made


@pytest.mark.parametrize("withdraw", [ControlClient.stop, ControlClient.withdraw_start])
def test_a_survey_whose_parameters_are_not_accepted_yet_is_not_started_after_stop(client, withdraw):
    client.start_survey(default_parameters())
    assert client._set_parameters.called.wait(LIMIT_S)
    withdraw(client)
    client._set_parameters.may_answer.set()
    assert client.answered.wait(LIMIT_S)
    assert client.taken == [Answer(Request.START, False, WITHDRAWN)]
    assert not client._start.called.is_set()


def test_a_survey_is_started_after_an_earlier_stop(client):
    client.stop()
    client._set_parameters.may_answer.set()
    client.start_survey(default_parameters())
    assert client.answered.wait(LIMIT_S)
    assert client._start.called.is_set()
    # The plan that it has set, whatever another client has set meanwhile.
    assert client._start.fields["plan_id"] == "0123"
    assert client.taken[-1].success
