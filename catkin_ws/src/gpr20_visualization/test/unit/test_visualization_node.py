"""The node completes recordings without tf."""

import json
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

import rospy
from std_msgs.msg import String
from test_robot_model import URDF
from test_survey_picture import DESCRIPTION, line

from gpr20_common.high.diagnostics import OK, WARN
from gpr20_msgs.msg import Coordinates, Trace
from gpr20_survey.axes import BASE_LINK, MAP
from gpr20_survey.trace import trace_message
from gpr20_visualization.high import visualization_node
from gpr20_visualization.high.visualization_node import VisualizationNode

# Of a recording that was made long ago.
STAMP = rospy.Time(1_600_000_000, 250_000_000)


@pytest.fixture
def graph(monkeypatch):
    """What is published, by topic, and what is subscribed to."""
    made = SimpleNamespace(sent={}, latched=set(), handlers={})

    def publisher(name, _kind, queue_size, latch):
        made.latched |= {name} if latch else set()
        return SimpleNamespace(publish=made.sent.setdefault(name, []).append)

    def subscriber(name, _kind, handler, queue_size):
        made.handlers[name] = handler

    for place, name, value in (
        (rospy, "Publisher", publisher),
        (rospy, "Subscriber", subscriber),
        (visualization_node, "Diagnostics", lambda _name, health: health),
    ):
        monkeypatch.setattr(place, name, value)
    made.node = VisualizationNode(URDF.read_text())
    return made


def from_player(message, md5sum=""):
    message._connection_header = {"callerid": "/player", "md5sum": md5sum}
    return message


def at(x_mm=100.0):
    message = Coordinates(x_mm=x_mm, y_mm=200.0, z_deg=90.0)
    message.header.stamp = STAMP
    return from_player(message)


def recorded(trace):
    raw = rospy.AnyMsg()
    raw._buff = trace_message.encode(trace)
    return from_player(raw, Trace._md5sum)


def play(graph):
    graph.handlers["survey_metadata"](from_player(String(json.dumps(DESCRIPTION))))
    graph.handlers["control_current_coordinate"](at())
    for one in line(20.0):
        graph.handlers["trace"](recorded(one))


def test_it_completes_a_recording_without_tf(graph):
    # Alone it has advertised nothing: a replay refuses topics that another node publishes.
    assert graph.sent == {}
    play(graph)
    assert graph.latched == visualization_node.LATCHED
    (moving,) = graph.sent["tf"]
    assert [round(one.transform.translation.y, 9) for one in moving.transforms] == [0.2, 0.0, 0.0]
    assert moving.transforms[0].header.stamp == graph.sent["joint_states"][0].header.stamp == STAMP
    fixed = graph.sent["tf_static"][0].transforms[0]
    assert (fixed.header.frame_id, fixed.child_frame_id) == (MAP, BASE_LINK)
    assert '<robot name="gpr20">' in graph.sent["robot_description"][0].data
    (area,), (stops,), (picture,) = (graph.sent[one] for one in ("survey_area", "stops", "b_scan"))
    assert area.action == area.ADD and (area.points[0].x, area.points[0].y) == (0.01, 0.04)
    assert [round(one.x, 3) for one in stops.points] == [0.01, 0.02, 0.03]
    assert len(picture.data) == picture.height * picture.width and any(picture.data)
    assert graph.node._diagnostics()[0] == OK


def test_what_cannot_be_shown_is_left_out_and_told(graph):
    graph.handlers["control_current_coordinate"](at(float("nan")))
    graph.handlers["trace"](from_player(rospy.AnyMsg(), "no such type"))
    level, message, _values = graph.node._diagnostics()
    assert graph.sent == {} and level == WARN and message.fault_code
