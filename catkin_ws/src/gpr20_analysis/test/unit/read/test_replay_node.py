"""What the replay publishes, of today's and of older recordings, without a ROS master."""

import struct
from types import SimpleNamespace

import pytest

pytest.importorskip("gpr20_msgs.msg")

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from genpy.dynamic import generate_dynamic
from imported_kit import imported_folder
from mcap.writer import Writer
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header, String
from survey_kit import POINTS, SURVEY, planned_trace

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.high import graph as other_nodes
from gpr20_analysis.high import old_recordings, replay_marker, replay_node
from gpr20_common.errors import NodeGoneError
from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.message import Message
from gpr20_msgs.msg import (
    AuxValue,
    AxisActionResult,
    CandidateList,
    ControlStatus,
    CurrentCoordinate,
    NodeDescription,
    Replay,
    RobotConfiguration,
    ServiceStatus,
    SurveyCoverage,
    Trace,
)
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace import trace_message

PLAN = ("string plan_id", "string plan_set_by")
CODE = ("string fault_code", *PLAN)
ZERO = ("uint32 zero_epoch", "time zero_time")
VERSION = ("string version", "string revision", "string host")
TRACES = [
    ("uint32[3] zero_epochs", "time[3] zero_times"),
    ("std_msgs/Header", "AuxValue[]"),
    ("float64 if_bandwidth_hz", "int32 averages", "string output_power"),
]


class Graph:
    """The ROS graph: what is published, by topic, who else publishes, and the services."""

    def __init__(self):
        self.sent, self.others, self.services, self.gone = {}, {}, {}, set()

    def publisher(self, name, data_class, **_):
        def publish(message):
            self.sent.setdefault(name, []).append(serialized(message))

        return SimpleNamespace(
            name=name, data_class=data_class, publish=publish, get_num_connections=lambda: 0
        )

    def probe(self, _uri, _caller, node, _limit_s):
        if node in self.gone:
            raise NodeGoneError(Message("gone"))
        return SimpleNamespace(process=lambda: 1)

    def received(self, topic, kind):
        return [deserialized(kind, data) for data in self.sent.get(topic, ())]


@pytest.fixture
def graph(monkeypatch):
    made = Graph()
    state = SimpleNamespace(getSystemState=lambda: (list(made.others.items()), [], []))
    for place, name, value in (
        (rospy, "Publisher", made.publisher),
        (rospy, "init_node", lambda *_, **__: None),
        (rospy, "on_shutdown", lambda _stop: None),
        (rosgraph, "is_master_online", lambda: True),
        (rosgraph, "Master", lambda _caller: state),
        (other_nodes, "NodeProbe", made.probe),
        (replay_marker, "advertise", lambda name, _kind, do: made.services.setdefault(name, do)),
        (replay_node, "subscriber_count", lambda _name: 0),
        *((replay_node, f"{name}_S", 0.0) for name in ("CONNECT_WAIT", "FIRST_WAIT", "LINGER")),
    ):
        monkeypatch.setattr(place, name, value)
    return made


def test_every_trace_comes_back_from_mcap_and_from_json_files(graph, finished):
    for number, part in enumerate((finished, finished / "traces")):
        assert main(["replay", str(part), "--rate", "1e4", "--ns", f"r{number}"]) == 0
        found = graph.received(f"/r{number}/trace", Trace)
        assert len(found) == len(POINTS)
        for index, message in enumerate(found):
            trace = planned_trace(index)
            assert message.index == index and message.x_coord_mm == trace.x_coord_mm
            assert list(message.s21_real) == trace.s21_real.tolist()
            assert list(message.s21_imag) == trace.s21_imag.tolist()
        first, *_, last = graph.received(f"/r{number}/replay", Replay)
        assert (first.survey_id, first.state, last.state) == (SURVEY, Replay.PLAYING, Replay.ENDED)
    (metadata,) = graph.received("/r0/survey_metadata", String)
    assert "planned_traces" in metadata.data


def test_an_imported_survey_comes_back_without_a_plan(graph, tmp_path):
    assert main(["replay", str(imported_folder(tmp_path, 5)), "--rate", "100"]) == 0
    found = graph.received("/replay/trace", Trace)
    assert [(one.index, one.x_coord_mm) for one in found] == [(n, 20.0 * n) for n in range(5)]
    (metadata,) = graph.received("/replay/survey_metadata", String)
    assert '"imported"' in metadata.data and "planned_traces" not in metadata.data


def test_it_is_refused_on_topics_of_others_but_not_of_the_dead(graph, finished, refusals):
    graph.others["/trace"] = ["/robot"]
    for part in (finished, finished / "traces"):
        assert main(["replay", str(part), "--ns", "/", "--rate", "1e4"]) == 3
    assert refusals == [faults.ROBOT_RUNS.code] * 2 and graph.sent == {}
    for name in ("a b", "1st", "../x", "a//b"):
        assert main(["replay", str(finished), "--ns", name]) == 3 and graph.sent == {}, name
    assert main(["replay", str(finished), "--rate", "1e4"]) == 0
    assert "/trace" not in graph.sent
    graph.gone.add("/robot")
    assert main(["replay", str(finished), "--ns", "/", "--rate", "1e4"]) == 0
    assert len(graph.sent["/trace"]) == len(POINTS)


def test_a_survey_of_a_robot_with_a_namespace_comes_in_that_of_the_replay(graph, tmp_path):
    names = ("robot1/main_control: state", "/robot2/main_control: state", "camera: state")
    reports = DiagnosticArray(status=[DiagnosticStatus(name=name) for name in names])
    graph.others["/rosout_agg"] = ["/rosout"]
    recording = write_latched(
        tmp_path / "robot1.mcap",
        ("/robot1/survey_metadata", String("{}")),
        ("/diagnostics", reports),
        ("/rosout_agg", Log(msg="recorded")),
    )
    assert main(["replay", str(recording), "--rate", "1e4", "--ns", "again/of_robot1"]) == 0
    assert len(graph.received("/again/of_robot1/survey_metadata", String)) == 1
    (found,) = graph.received("/again/diagnostics", DiagnosticArray)
    assert [one.name for one in found.status] == ["/again/of_robot1/main_control: state"]


def write_latched(path, *messages):
    """Write messages into an MCAP file as the storage does."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros1")
        for second, (topic, message) in enumerate(messages):
            text = message._full_text.encode("utf-8")
            schema = writer.register_schema(message._type, "ros1msg", text)
            metadata = {"md5sum": message._md5sum, "latching": "1"}
            channel = writer.register_channel(topic, "ros1", schema, metadata)
            time_ns = second * 1_000_000_000
            writer.add_message(channel, time_ns, serialized(message), time_ns)
        writer.finish()
    return path


def old_type(kind, *added):
    """Return a type as it was without the fields that were added."""
    lines = [line for line in kind._full_text.splitlines() if not line.startswith(added)]
    return generate_dynamic(kind._type, "\n".join(lines))[kind._type]


def today(topic, message, kind):
    """Return a recorded message as a node of today receives it."""
    recorded = RecordedMessage(
        f"{topic}_{message._md5sum[:8]}",
        *(message._type, message._md5sum, message._full_text, serialized(message), 0),
    )
    found = old_recordings.completed(recorded)
    assert (found.topic, found.md5sum) == (topic, kind._md5sum)
    return deserialized(kind, found.data)


@pytest.mark.parametrize(
    ("kind", "added", "values"),
    [
        (ControlStatus, ("string message_json", *CODE), {"code": 4, "simulated": True}),
        (ControlStatus, PLAN, {"code": 5, "fault_code": "a.b"}),
        (ControlStatus, (), {"code": 5, "plan_id": "p"}),
        (ServiceStatus, CODE, {"message": "the axis is not homed"}),
        (SurveyCoverage, ("string[] failures_json", "string verdict_json"), {"verdict": "x"}),
        (CurrentCoordinate, (*ZERO, "string owner"), {"coordinate": 20.0, "homed": True}),
        (NodeDescription, VERSION, {"node": "height_sensor", "time_scale": 2.0}),
        (RobotConfiguration, CODE, {"known": True, "site_json": "{1}"}),
    ],
)
def test_a_message_of_an_older_version_arrives_as_one_of_today(kind, added, values):
    found = today("/x", old_type(kind, *added)(**values) if added else kind(**values), kind)
    assert found == deserialized(kind, serialized(kind(**values)))


def test_results_and_configurations_of_an_older_robot_arrive_with_what_they_hold():
    result = old_type(AxisActionResult, *CODE, *ZERO)()
    result.result.message = "the axis is not homed"
    found = today("/x_axis/result", result, AxisActionResult).result
    assert (found.message, found.fault_code, found.zero_epoch) == (result.result.message, "", 0)
    described = old_type(NodeDescription, *VERSION)
    names = ["x_axis/axis_driver", "height_sensor"]
    nodes = [described(node=one, hardware="DRV8825", time_scale=2.0) for one in names]
    robot = old_type(RobotConfiguration, *VERSION, "string fault_code")(nodes=nodes)
    assert robot._md5sum == old_recordings.FORMER_MD5SUM
    found = today("/robot_configuration", robot, RobotConfiguration)
    assert [(one.node, one.time_scale, one.host) for one in found.nodes] == [
        (one, 2.0, "") for one in names
    ]


def test_a_trace_of_each_version_arrives_as_one_of_today():
    stamp = rospy.Time(1_790_000_000)
    settings = {"if_bandwidth_hz": 1000.0, "averages": 4, "output_power": "HIGH"}
    for count, md5sum in zip((1, 2, 3), trace_message.FORMER_MD5SUMS):
        former = old_type(Trace, *sum(TRACES[:count], ()))
        assert former._md5sum == md5sum
        values = {"index": count, "timestamp": stamp, "s21_real": [0.5], "quality": ["remark"]}
        values.update(settings if count < 3 else {})
        values.update({"aux": [AuxValue("soil", 0.25, "m3/m3", stamp)]} if count == 1 else {})
        found = today("/trace", former(**values), Trace)
        assert (found.index, found.s21_real, found.quality) == (count, (0.5,), ["remark"])
        assert found.aux == values.get("aux", [])
        assert count == 1 or found.header == Header(count, stamp, "antenna_link")
        for name, empty in zip(settings, (0.0, 0, "")):
            assert getattr(found, name) == values.get(name, empty)


def test_a_configuration_that_is_cut_off_anywhere_is_refused():
    def text(words):
        return struct.pack("<I", len(words)) + words

    node = text(b"x_axis") + text(b"DRV8825") + b"\1" + struct.pack("<d", 2.0) + text(b"{}")
    begin = bytes(12) + text(b"") + b"\1" + text(b"why") + text(b"{}") + b"\0"
    for size in range(len(begin + node)):
        with pytest.raises(ValueError, match="cut off"):
            old_recordings.completed_configuration((begin + b"\1\0\0\0" + node)[:size])


def test_a_former_list_of_candidates_is_not_said_to_be_one_of_today():
    # Its levels were above noise, and its false alarms a probability: it says something else.
    text = CandidateList._full_text.replace("above_clutter_db", "above_noise_db")
    former = generate_dynamic(CandidateList._type, text)[CandidateList._type]
    for kind in (former, CandidateList):
        recorded = RecordedMessage("/candidates", kind._type, kind._md5sum, text, b"", 0)
        assert old_recordings.completed(recorded) == recorded
