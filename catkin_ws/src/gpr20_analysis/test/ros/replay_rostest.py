#!/usr/bin/env python3
"""A recorded survey comes back in the namespace of the replay, from MCAP and from JSON."""

from __future__ import annotations

import functools
import io
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Any, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from genpy.dynamic import generate_dynamic
from mcap.writer import Writer
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header, String

from gpr20_analysis.high import old_recordings
from gpr20_msgs.msg import (
    AuxValue,
    AxisActionResult,
    ControlStatus,
    CurrentCoordinate,
    NodeDescription,
    RobotConfiguration,
    ServiceStatus,
    SurveyCoverage,
    Trace,
)
from gpr20_survey.trace import trace_message

PARENTS = Path(__file__).resolve().parents
sys.path[:0] = [str(PARENTS[1] / "unit"), str(PARENTS[5] / "tools/kits")]
from imported_kit import imported_folder  # noqa: E402
from survey_kit import POINTS, make_survey, planned_trace  # noqa: E402

TIME_LIMIT_S = 60.0
FAULT_CODE = "string fault_code"
PLAN = ("string plan_id", "string plan_set_by")
ZERO = ("uint32 zero_epoch", "time zero_time")
NODE = Path(__file__).resolve().parents[2] / "nodes" / "replay"


class ReplayTest(unittest.TestCase):
    def setUp(self) -> None:
        self.data = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.data, ignore_errors=True)
        self.folder = make_survey(self.data, len(POINTS), "finished")
        self.changed = threading.Condition()
        self.traces = []
        self.metadata = []
        self.subscribers = [
            rospy.Subscriber("/replay/trace", Trace, self.on_trace),
            rospy.Subscriber("/replay/survey_metadata", String, self.on_metadata),
        ]
        self.addCleanup(lambda: [one.unregister() for one in self.subscribers])

    def on_trace(self, message: Trace) -> None:
        with self.changed:
            self.traces.append(message)
            self.changed.notify_all()

    def on_metadata(self, message: String) -> None:
        with self.changed:
            self.metadata.append(message.data)
            self.changed.notify_all()

    def run_node(self, survey: Path, *options: str) -> subprocess.CompletedProcess:
        command = [sys.executable, str(NODE), str(survey), *options]
        return subprocess.run(command, timeout=TIME_LIMIT_S, capture_output=True, text=True)

    def replay(self, survey: Path, *options: str) -> None:
        done = self.run_node(survey, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        with self.changed:
            found = self.changed.wait_for(lambda: len(self.traces) >= len(POINTS), TIME_LIMIT_S)
        self.assertTrue(found, f"{len(self.traces)} traces came back")

    def assert_same(self) -> None:
        for index, message in enumerate(self.traces):
            trace = planned_trace(index)
            self.assertEqual(message.index, index)
            self.assertEqual(list(message.s21_real), trace.s21_real.tolist())
            self.assertEqual(list(message.s21_imag), trace.s21_imag.tolist())
            self.assertEqual(message.x_coord_mm, trace.x_coord_mm)

    def test_every_trace_comes_back_from_mcap_with_the_metadata(self) -> None:
        self.replay(self.folder, "--rate", "100")
        self.assert_same()
        with self.changed:
            self.changed.wait_for(lambda: self.metadata, TIME_LIMIT_S)
        self.assertIn("planned_traces", self.metadata[0])

    def test_an_imported_survey_comes_back_one_trace_after_the_other(self) -> None:
        folder = imported_folder(self.data, len(POINTS))
        begun_s = time.monotonic()
        self.replay(folder, "--rate", "2")
        took_s = time.monotonic() - begun_s
        indices = [message.index for message in self.traces]
        self.assertEqual(indices, list(range(len(POINTS))))
        places_mm = [message.x_coord_mm for message in self.traces]
        self.assertEqual(places_mm, [20.0 * index for index in indices])
        # 0.1 s between two traces, as their source says no times.
        self.assertGreaterEqual(took_s, (len(POINTS) - 1) * 0.1 / 2)
        with self.changed:
            self.changed.wait_for(lambda: self.metadata, TIME_LIMIT_S)
        self.assertIn('"imported"', self.metadata[0])
        self.assertNotIn("planned_traces", self.metadata[0])

    def test_every_trace_comes_back_from_json_files_alone_at_the_rate(self) -> None:
        # One trace was taken each second. Of the replay itself, whose end no stall brings forward:
        # this process may receive several at once.
        begun_s = time.monotonic()
        self.replay(self.folder / "traces", "--rate", "4")
        took_s = time.monotonic() - begun_s
        self.assert_same()
        self.assertGreaterEqual(took_s, (len(POINTS) - 1) / 4)

    def test_traces_of_all_versions_of_a_resumed_survey_arrive_on_one_topic(self) -> None:
        zeros = ("uint32[3] zero_epochs", "time[3] zero_times")
        added = ("std_msgs/Header", "AuxValue[]", *zeros)
        old = old_message(Trace, *zeros)
        older = old_message(Trace, *added)
        oldest = old_message(
            Trace, *added, "float64 if_bandwidth_hz", "int32 averages", "string output_power"
        )
        former = (old._md5sum, older._md5sum, oldest._md5sum)
        self.assertEqual(former, trace_message.FORMER_MD5SUMS)
        recording = self.data / "old.mcap"
        settings = {"if_bandwidth_hz": 1000.0, "averages": 4, "output_power": "HIGH"}
        values = {"timestamp": rospy.Time(1_790_000_000), "s21_real": [0.5], "quality": ["remark"]}
        aux = [AuxValue("soil", 0.25, "m3/m3", rospy.Time(1_790_000_000))]
        write_latched(
            recording,
            ("/trace", oldest(index=0, sample_id="0", **values)),
            (f"/trace_{older._md5sum[:8]}", older(index=1, sample_id="1", **values, **settings)),
            (f"/trace_{old._md5sum[:8]}", old(index=2, sample_id="2", **settings, aux=aux)),
            (f"/trace_{older._md5sum[:8]}", older(index=3, sample_id="3", **values, **settings)),
        )
        self.run_node(recording, "--rate", "4")
        with self.changed:
            self.changed.wait_for(lambda: len(self.traces) >= 4, TIME_LIMIT_S)
        first, second, third, last = self.traces
        for index, trace in ((0, first), (1, second), (3, last)):
            self.assertEqual((trace.index, trace.sample_id), (index, str(index)))
            self.assertEqual(trace.header, Header(index, values["timestamp"], "antenna_link"))
            self.assertEqual((trace.s21_real, trace.quality), ((0.5,), ["remark"]))
            self.assertEqual(trace.aux, [])
        self.assertEqual((first.if_bandwidth_hz, first.averages, first.output_power), (0.0, 0, ""))
        self.assertEqual((third.sample_id, third.aux), ("2", aux))
        for trace in (second, third, last):
            self.assertEqual({name: getattr(trace, name) for name in settings}, settings)

    def test_the_configuration_of_an_older_robot_arrives_as_that_of_today(self) -> None:
        added = ("string version", "string revision", "string host")
        old_description = old_message(NodeDescription, *added)
        old_robot = old_message(RobotConfiguration, *added, FAULT_CODE)
        self.assertEqual(old_robot._md5sum, old_recordings.FORMER_MD5SUM)
        nodes = [
            old_description(node=node, hardware="DRV8825", time_scale=2.0)
            for node in ("x_axis/axis_driver", "height_sensor")
        ]
        recording = self.data / "old.mcap"
        write_latched(
            recording,
            ("/height_sensor/description", nodes[1]),
            ("/robot_configuration", old_robot(known=True, nodes=nodes, site_json="{1}")),
        )
        received = []
        for topic, kind in (
            ("/replay/height_sensor/description", NodeDescription),
            ("/replay/robot_configuration", RobotConfiguration),
        ):
            self.subscribers.append(rospy.Subscriber(topic, kind, received.append))
        self.run_node(recording, "--rate", "4")
        deadline_s = time.monotonic() + TIME_LIMIT_S
        while len(received) < 2 and time.monotonic() < deadline_s:
            time.sleep(0.01)
        description, configuration = sorted(received, key=lambda one: one._type)
        self.assertEqual((description.node, description.version), ("height_sensor", ""))
        self.assertEqual((configuration.known, configuration.site_json), (True, "{1}"))
        self.assertEqual(
            [(one.node, one.hardware, one.time_scale, one.host) for one in configuration.nodes],
            [(one.node, "DRV8825", 2.0, "") for one in nodes],
        )

    def test_messages_of_an_older_version_arrive_as_those_of_today(self) -> None:
        old_status = old_message(ControlStatus, "string message_json", FAULT_CODE, *PLAN)
        self.assertIn(old_message(ControlStatus, *PLAN)._md5sum, old_recordings.ADDED)
        old_coverage = old_message(SurveyCoverage, "string[] failures_json", "string verdict_json")
        recording = self.data / "old.mcap"
        write_latched(
            recording,
            (
                "/survey_coverage",
                old_coverage(planned=2, failures=["1: lost"], verdict="INCOMPLETE"),
            ),
            ("/control_status", old_status(code=4, message="measuring", simulated=True)),
            (
                f"/control_status_{ControlStatus._md5sum[:8]}",
                ControlStatus(code=5, message="Paused", message_json="{}"),
            ),
        )
        received = []
        for topic, kind in (
            ("/replay/control_status", ControlStatus),
            ("/replay/survey_coverage", SurveyCoverage),
        ):
            self.subscribers.append(rospy.Subscriber(topic, kind, received.append))
        self.run_node(recording, "--rate", "4")
        statuses = [one for one in received if isinstance(one, ControlStatus)]
        self.assertEqual(
            [(one.message, one.message_json, one.simulated) for one in statuses],
            [("measuring", "", True), ("Paused", "{}", False)],
        )
        (coverage,) = [one for one in received if isinstance(one, SurveyCoverage)]
        self.assertEqual((coverage.failures, coverage.verdict), (["1: lost"], "INCOMPLETE"))
        self.assertEqual((coverage.failures_json, coverage.verdict_json), ([], ""))

    def test_messages_of_the_version_before_the_fault_codes_arrive_without_one(self) -> None:
        kinds = (ControlStatus, ServiceStatus, RobotConfiguration, AxisActionResult)
        messages = [old_message(kind, FAULT_CODE, *PLAN, *ZERO)() for kind in kinds]
        *said, result = messages
        for one in (*said, result.result):
            one.message, one.message_json = "the axis is not homed", '{"template": "x"}'
        said[2].site_json = "{1}"
        topics = ("/control_status", "/service_status", "/robot_configuration", "/x_axis/result")
        recording = self.data / "old.mcap"
        write_latched(recording, *zip(topics, messages))
        received = {}
        for topic, kind in zip(topics, kinds):
            take = functools.partial(received.__setitem__, topic)
            self.subscribers.append(rospy.Subscriber(f"/replay{topic}", kind, take))
        self.run_node(recording, "--rate", "4")
        deadline_s = time.monotonic() + TIME_LIMIT_S
        while len(received) < len(topics) and time.monotonic() < deadline_s:
            time.sleep(0.01)
        self.assertEqual(sorted(received), sorted(topics))
        self.assertEqual(received["/robot_configuration"].site_json, "{1}")
        received["/x_axis/result"] = received["/x_axis/result"].result
        for one in received.values():
            self.assertEqual(
                (one.message, one.message_json, one.fault_code),
                ("the axis is not homed", '{"template": "x"}', ""),
            )

    def test_coordinates_of_the_version_before_the_zeros_arrive_without_one(self) -> None:
        recording = self.data / "old.mcap"
        old = old_message(CurrentCoordinate, *ZERO, "string owner")
        write_latched(recording, ("/x_axis/current_coord", old(coordinate=20.0, homed=True)))
        received = []
        topic = "/replay/x_axis/current_coord"
        self.subscribers.append(rospy.Subscriber(topic, CurrentCoordinate, received.append))
        self.run_node(recording, "--rate", "4")
        deadline_s = time.monotonic() + TIME_LIMIT_S
        while not received and time.monotonic() < deadline_s:
            time.sleep(0.01)
        (one,) = received
        self.assertEqual(
            (one.coordinate, one.homed, one.zero_epoch, one.owner), (20.0, True, 0, "")
        )

    def test_beside_a_robot_it_is_published_elsewhere_and_never_on_its_topics(self) -> None:
        robot = rospy.Publisher("/trace", Trace, queue_size=1)
        self.addCleanup(robot.unregister)
        of_robot = []
        own = rospy.Subscriber("/trace", Trace, of_robot.append)
        self.addCleanup(own.unregister)
        for survey in (self.folder, self.folder / "traces"):
            done = self.run_node(survey, "--rate", "100", "--ns", "/")
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn(f"/trace is published by {rospy.get_name()}", done.stderr)
            self.assertIn("in another namespace", done.stderr)
        self.assertEqual(self.traces, [])
        self.replay(self.folder, "--rate", "100")
        self.assert_same()
        self.assertEqual(of_robot, [])

    def test_a_survey_of_a_robot_with_a_namespace_comes_in_that_of_the_replay(self) -> None:
        names = ("robot1/main_control: state", "/robot2/main_control: state", "camera: state")
        reports = DiagnosticArray(status=[DiagnosticStatus(name=name) for name in names])
        recording = self.data / "robot1.mcap"
        write_latched(
            recording,
            ("/robot1/survey_metadata", String("{}")),
            ("/diagnostics", reports),
        )
        received = []
        for topic, kind in (
            ("/again/of_robot1/survey_metadata", String),
            ("/again/diagnostics", DiagnosticArray),
        ):
            self.subscribers.append(rospy.Subscriber(topic, kind, received.append))
        self.run_node(recording, "--rate", "100", "--ns", "again/of_robot1")
        deadline_s = time.monotonic() + TIME_LIMIT_S
        while len(received) < 2 and time.monotonic() < deadline_s:
            time.sleep(0.01)
        (found,) = [one.status for one in received if isinstance(one, DiagnosticArray)]
        self.assertEqual([one.name for one in found], ["/again/of_robot1/main_control: state"])

    def test_what_is_no_namespace_is_refused(self) -> None:
        for name in ("a b", "1st", "../x", "a//b"):
            done = self.run_node(self.folder, "--ns", name)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("is no namespace of ROS", done.stderr)

    def test_a_second_replay_is_refused_in_the_same_namespace_and_never_ends_the_first(
        self,
    ) -> None:
        command = [sys.executable, str(NODE), str(self.folder), "--rate", "100", "--hold"]
        first = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        self.addCleanup(first.wait)
        self.addCleanup(first.kill)
        with self.changed:
            self.changed.wait_for(lambda: len(self.traces) >= len(POINTS), TIME_LIMIT_S)
        done = self.run_node(self.folder)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("another replay uses these topics", done.stderr)
        beside = self.run_node(self.folder, "--ns", "replay2", "--rate", "100")
        self.assertEqual(beside.returncode, 0, beside.stderr)
        self.assertEqual(len(self.traces), len(POINTS))
        self.assertIsNone(first.poll())

    def test_a_recorded_log_is_replayed_beside_the_log_node_of_the_master(self) -> None:
        recording = self.data / "log.mcap"
        write_latched(recording, ("/rosout_agg", Log(msg="recorded")))
        node = rospy.Publisher("/rosout_agg", Log, queue_size=1)
        self.addCleanup(node.unregister)
        done = self.run_node(recording, "--ns", "/")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("1 messages", done.stdout)

    def test_the_launch_file_replays_a_folder_named_from_where_it_is_called(self) -> None:
        named = self.data / 'a "survey" of señor O\'Neill & <sons> $HOME'
        self.folder.rename(named)
        command = ["roslaunch", "gpr20", "replay.launch", f"survey:={named.name}", "rate:=100"]
        subprocess.run(
            command, check=True, timeout=2 * TIME_LIMIT_S, stdout=subprocess.DEVNULL, cwd=self.data
        )
        with self.changed:
            self.changed.wait_for(lambda: len(self.traces) >= len(POINTS), TIME_LIMIT_S)
        self.assert_same()
        self.assertEqual(len(self.traces), len(POINTS))


def old_message(kind: type, *added: str) -> type:
    """Return a type as it was without the fields that were added."""
    lines = [line for line in kind._full_text.splitlines() if not line.startswith(added)]
    return generate_dynamic(kind._type, "\n".join(lines))[kind._type]


def write_latched(path: Path, *messages: Tuple[str, Any]) -> None:
    """Write messages, one a second, into an MCAP file as the storage does."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros1")
        for second, (topic, message) in enumerate(messages):
            buffer = io.BytesIO()
            message.serialize(buffer)
            schema = writer.register_schema(
                message._type, "ros1msg", message._full_text.encode("utf-8")
            )
            metadata = {"md5sum": message._md5sum, "latching": "1"}
            channel = writer.register_channel(topic, "ros1", schema, metadata)
            time_ns = second * 1_000_000_000
            writer.add_message(channel, time_ns, buffer.getvalue(), time_ns)
        writer.finish()


if __name__ == "__main__":
    import rostest

    rospy.init_node("replay_test")
    rostest.rosrun("gpr20_analysis", "replay_survey", ReplayTest)
