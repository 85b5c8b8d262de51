"""Axes and devices over ROS, without a graph: what their services and goals answer."""

import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("actionlib")
pytest.importorskip("gpr20_msgs.msg")

import rospy
from fake_robot import LIMIT_S
from fault_kit import raises_fault

from gpr20_common.faults import PART_LOST
from gpr20_common.high import service_client
from gpr20_common.high.answers import message_fields
from gpr20_common.high.raw_message import serialized
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.high import ros_devices
from gpr20_main_control.high.survey_topics import listen_to_nodes
from gpr20_main_control.mid.waits import Workers
from gpr20_msgs.msg import AxisResult, NodeDescription
from gpr20_msgs.srv import CommandResponse
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import CONTROL_SILENT

NO_CONTACT = Message("the axis stopped by itself").with_fault(CONTROL_SILENT)
STOPPED = Message("the move was stopped")


@pytest.fixture
def graph(monkeypatch):
    """Services whose nodes are away, and what was called once they were back."""
    graph = Graph()
    monkeypatch.setattr(
        service_client,
        "ServiceConnection",
        lambda _uri, header, *_others: Connection(graph, header["service"].lstrip("/")),
    )
    monkeypatch.setattr(service_client.ServiceClient, "_look_up", lambda *_arguments: "")
    monkeypatch.setattr(rospy, "Subscriber", lambda *_arguments, **_options: None)
    monkeypatch.setattr(ros_devices, "_DriversClient", lambda *_arguments: None)
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
        if self.name == graph.away:
            graph.waiting.set()
            graph.node_is_back.wait(LIMIT_S)

    def call(self, _request, _deadline_s):
        return serialized(self.graph.call(self.name))

    def abort(self):
        pass

    def close(self):
        pass


def test_a_homing_that_waits_for_its_node_is_not_begun_after_a_stop(graph):
    graph.away = "x_axis/homing"
    axis = ros_devices.RosAxis(AxisId.X, Clock())
    homing = Workers().begin(lambda: axis.home(LIMIT_S))
    assert graph.waiting.wait(LIMIT_S)
    axis.stop()
    graph.node_is_back.set()
    with raises_fault(PART_LOST, error=NodeLostError) as lost:
        homing.result(LIMIT_S)
    assert lost.value.message.may_move
    # Its call belongs to this test's graph, not to the next one's.
    axis._await_stops()
    assert graph.called == ["x_axis/stop"]


def test_a_homing_begins_only_when_the_stop_before_it_is_over(graph):
    axis = ros_devices.RosAxis(AxisId.X, Clock())
    axis._stops = [SimpleNamespace(join=lambda _limit_s: graph.called.append("stop is over"))]
    axis.home(LIMIT_S)
    assert graph.called == ["stop is over", "x_axis/homing"]


def test_a_recording_beside_the_robot_is_not_taken_for_its_driver(monkeypatch):
    noted, heard, driver = [], {}, "x_axis/axis_driver"
    monkeypatch.setattr(rospy, "Subscriber", lambda topic, _kind, take: heard.update({topic: take}))
    listen_to_nodes(noted.append)
    for publisher in (f"/{driver}", "/rosbag_play"):
        message = NodeDescription(configuration_json="{}")
        message._connection_header = {"callerid": publisher}
        heard[f"{driver}/description"](message)
    assert [one.node for one in noted] == [driver]


def test_every_call_of_the_storage_ends():
    calls = vars(ros_devices.RosStorage(None)).values()
    limits_s = [one.time_limit_s for one in calls if isinstance(one, ros_devices.DeviceService)]
    assert len(limits_s) == 5 and max(limits_s) < 900.0


def ended_goal(message):
    """Return the handle of a goal that ended without success."""
    result = message and AxisResult(success=False, **message_fields(message))
    return SimpleNamespace(get_result=lambda: result, get_goal_status_text=str)


def test_a_stop_for_lack_of_contact_is_told_from_one_that_was_requested():
    failures = [ros_devices.move_failure(ended_goal(one)) for one in (NO_CONTACT, STOPPED, None)]
    assert [isinstance(one, NodeLostError) for one in failures] == [True, False, False]
    # Without a result the move may continue.
    assert failures[2].message.fault_code == PART_LOST.code


def test_a_homing_that_stopped_for_lack_of_contact_is_no_failed_axis(graph, monkeypatch):
    response = CommandResponse(success=False, **message_fields(NO_CONTACT))
    monkeypatch.setattr(graph, "call", lambda _name: response)
    with raises_fault(CONTROL_SILENT, error=NodeLostError):
        ros_devices.RosAxis(AxisId.X, Clock()).home(LIMIT_S)
