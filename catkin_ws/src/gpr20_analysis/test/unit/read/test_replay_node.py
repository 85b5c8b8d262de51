"""What the replay publishes of recordings, without a ROS master."""

from types import SimpleNamespace

import pytest

pytest.importorskip("gpr20_msgs.msg")

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from mcap.writer import Writer
from result_examples import imported_folder
from rosgraph_msgs.msg import Log
from std_msgs.msg import String
from survey_kit import POINTS, SURVEY, planned_trace

from gpr20_analysis import errors, replay_node
from gpr20_analysis.commands.main import main
from gpr20_common.errors import NodeGoneError
from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.message import Message
from gpr20_msgs.msg import Replay, Trace


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
        (replay_node, "NodeProbe", made.probe),
        (replay_node, "advertise", lambda name, _kind, do: made.services.setdefault(name, do)),
        (replay_node, "subscriber_count", lambda _name: 0),
        *((replay_node, f"{name}_S", 0.0) for name in ("CONNECT_WAIT", "FIRST_WAIT", "LINGER")),
    ):
        monkeypatch.setattr(place, name, value)
    return made


def test_every_trace_comes_back_from_mcap_and_from_a_bag(graph, finished):
    for number, part in enumerate((finished, finished / "survey.bag")):
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
    assert main(["replay", str(finished), "--ns", "/", "--rate", "1e4"]) == 3
    assert refusals == [errors.ROBOT_RUNS.code] and graph.sent == {}
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
