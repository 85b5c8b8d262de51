"""An axis over ROS, without a graph: what a stop does to a homing whose node is lost."""

import threading

import pytest

pytest.importorskip("actionlib")
pytest.importorskip("gpr20_msgs.msg")

import rospy
from fake_robot import LIMIT_S
from fault_kit import raises_fault

from gpr20_common.high import service_client
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.sent_message import message_fields
from gpr20_main_control import faults
from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.high import ros_axis
from gpr20_main_control.mid.waits import Workers
from gpr20_msgs.msg import AxisResult
from gpr20_msgs.srv import CommandResponse
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import CONTROL_SILENT

NO_CONTACT = Message("the axis stopped by itself").with_fault(CONTROL_SILENT)


@pytest.fixture
def graph(monkeypatch):
    """Services whose nodes are away, and what was called once they were back."""
    graph = Graph()
    monkeypatch.setattr(
        service_client, "ServiceConnection", lambda name, *_others: Connection(graph, name)
    )
    monkeypatch.setattr(service_client.ServiceClient, "_look_up", lambda *_arguments: "")
    monkeypatch.setattr(rospy, "Subscriber", lambda *_arguments, **_options: None)
    monkeypatch.setattr(ros_axis, "_DriversClient", lambda *_arguments: None)
    yield graph
    graph.node_is_back.set()


class Graph:
    def __init__(self):
        self.away = ""
        self.waiting, self.node_is_back = threading.Event(), threading.Event()
        self.called = []

    def call(self, name):
        self.called.append(name)
        return CommandResponse(success=True)


class Connection:
    """A connection to a service of the graph."""

    def __init__(self, graph, name):
        self.graph, self.name = graph, name

    def connect(self, _address, _timeout_s, _answer_timeout_s):
        if self.name == self.graph.away:
            self.graph.waiting.set()
            self.graph.node_is_back.wait(LIMIT_S)

    def call(self, _request, _timeout_s):
        return self.graph.call(self.name)

    def abort(self):
        pass

    def close(self):
        pass


def test_a_homing_that_waits_for_its_node_is_not_begun_after_a_stop(graph):
    graph.away = "x_axis/homing"
    axis = ros_axis.RosAxis(AxisId.X, Clock())
    homing = Workers().begin(lambda: axis.home(LIMIT_S))
    assert graph.waiting.wait(LIMIT_S)
    axis.stop()
    graph.node_is_back.set()
    with raises_fault(faults.AXIS_SILENT, error=NodeLostError) as lost:
        homing.result(LIMIT_S)
    assert lost.value.message.may_move
    # Its call belongs to this test's graph, not to the next one's.
    axis._await_stops()
    assert graph.called == ["x_axis/stop"]


def test_a_homing_begins_only_when_the_stop_before_it_is_over(graph):
    graph.away = "x_axis/stop"
    axis = ros_axis.RosAxis(AxisId.X, Clock())
    axis.stop()
    assert graph.waiting.wait(LIMIT_S)
    homing = Workers().begin(lambda: axis.home(LIMIT_S))
    graph.node_is_back.set()
    homing.result(LIMIT_S)
    assert graph.called == ["x_axis/stop", "x_axis/homing"]


class EndedGoal:
    """The handle of a goal that ended without success."""

    def __init__(self, message):
        self._result = AxisResult(success=False, **message_fields(message))

    def get_result(self):
        return self._result

    def get_goal_status_text(self):
        return ""


def test_a_stop_for_lack_of_contact_is_told_from_one_that_was_requested():
    assert ros_axis._outcome(EndedGoal(NO_CONTACT)).contact_lost
    assert not ros_axis._outcome(EndedGoal(Message("the move was stopped"))).contact_lost


def test_a_move_without_a_result_may_continue():
    goal = EndedGoal(NO_CONTACT)
    goal._result = None
    assert ros_axis._outcome(goal).message.fault_code == faults.AXIS_SILENT.code


def test_a_homing_that_stopped_for_lack_of_contact_is_no_failed_axis(graph, monkeypatch):
    response = CommandResponse(success=False, **message_fields(NO_CONTACT))
    monkeypatch.setattr(graph, "call", lambda _name: response)
    with raises_fault(CONTROL_SILENT, error=NodeLostError):
        ros_axis.RosAxis(AxisId.X, Clock()).home(LIMIT_S)
