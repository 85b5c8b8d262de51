#!/usr/bin/env python3
"""A survey stored through the services of the running node."""

from __future__ import annotations

import glob
import json
import math
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import uuid
from pathlib import Path

import genpy.dynamic
import numpy as np
import rosbag
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros1.decoder import DecoderFactory
from roscpp.srv import GetLoggers
from std_msgs.msg import String

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from sent_traces import make_trace, numbers

from gpr20_common.high.raw_message import serialized
from gpr20_common.message import Fault, Message
from gpr20_msgs.msg import ControlStatus, CurrentCoordinate, Trace
from gpr20_msgs.srv import (
    CloseSurvey,
    OpenSurvey,
    ReadTraces,
    ReopenSurvey,
    ReportSurvey,
    StoreData,
)
from gpr20_survey.recording import survey_topics
from gpr20_survey.trace import trace_message

PACKAGE = "gpr20_vna_processing"
NODE = Path(__file__).resolve().parents[2] / "nodes" / "vna_processing"
TIME_LIMIT_S = 60.0
TRACES = 6


# gpr20_msgs/ControlStatus as it was before it had a field for templates.
OLD_STATUS = """std_msgs/Header header
int32 code
string message
string survey_id
bool simulated
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
"""


class StoreSurveyTest(unittest.TestCase):
    @classmethod
    def tearDownClass(cls) -> None:
        shutil.rmtree(rospy.get_param("~data"))

    def setUp(self) -> None:
        self.data = rospy.get_param("~data")
        self.services = {
            name: self.service(name, kind)
            for name, kind in (
                ("open_survey", OpenSurvey),
                ("store_data", StoreData),
                ("close_survey", CloseSurvey),
            )
        }
        self.survey_id = str(uuid.uuid4())
        # A test that failed half way must not fail the next ones.
        self.addCleanup(self.close, "failed")

    def service(self, name: str, kind):
        rospy.wait_for_service(name, TIME_LIMIT_S)
        return rospy.ServiceProxy(name, kind)

    def wait_until(self, condition, what: str) -> None:
        deadline_s = time.monotonic() + TIME_LIMIT_S
        while not condition():
            self.assertLess(time.monotonic(), deadline_s, what)
            time.sleep(0.02)

    def open(self, **changes):
        request = {
            "survey_id": self.survey_id,
            "started": rospy.Time.now(),
            "metadata_json": '{"parameters": {"x_points": 3}}',
            "needed_bytes": 1_000_000,
        }
        return self.services["open_survey"](**{**request, **changes})

    def store(self, index: int, **changes):
        return self.services["store_data"](make_trace(self.survey_id, index, changes))

    def close(self, outcome: str = "finished", **more):
        request = {"survey_id": self.survey_id, "outcome": outcome, "reason": "by the test"}
        return self.services["close_survey"](**request, **more)

    def connected(self, publisher: rospy.Publisher) -> rospy.Publisher:
        self.wait_until(lambda: publisher.get_num_connections() > 0, "nobody records the topic")
        return publisher

    def collect(self, topic: str, kind) -> list:
        found: list = []
        subscriber = rospy.Subscriber(topic, kind, found.append)
        self.addCleanup(subscriber.unregister)
        self.wait_until(lambda: subscriber.get_num_connections() > 0, f"no publisher of {topic}")
        return found

    def check_read(self, path: str) -> None:
        """Compare what `read_traces` returns with what was stored."""
        read = self.service("read_traces", ReadTraces)
        stored = [make_trace(self.survey_id, index) for index in range(TRACES)]
        for survey in (self.survey_id, Path(path).name):
            answer = read(survey=survey, indices=[*range(TRACES), TRACES + 1])
            self.assertTrue(answer.success, answer.message)
            self.assertEqual(answer.survey_id, self.survey_id)
            for name in ("x_coord_mm", "y_coord_mm", "z_coord_deg"):
                self.assertEqual(getattr(answer, name), tuple(getattr(one, name) for one in stored))
            self.assertEqual(answer.indices, tuple(range(TRACES)))
            self.assertEqual(answer.frequency_hz, tuple(stored[0].frequency_hz))
            s21 = np.frombuffer(answer.s21, "<c8").reshape(TRACES, -1)
            own = [np.array(one.s21_real) + 1j * np.array(one.s21_imag) for one in stored]
            self.assertTrue(np.array_equal(s21, np.array(own).astype("<c8")))
            (unreadable,) = answer.unreadable
            self.assertIn(f"{TRACES + 1}: the storage has no file", unreadable)

    def test_1_a_survey_is_the_same_in_json_bag_mcap_and_topic(self) -> None:
        status = rospy.Publisher("control_status", ControlStatus, queue_size=1, latch=True)
        status.publish(ControlStatus(code=ControlStatus.SURVEYING, message="before the survey"))
        self.connected(status)
        axis = rospy.Publisher("x_axis/current_coord", CurrentCoordinate, queue_size=10)
        self.connected(axis)
        live = self.collect("trace", Trace)
        # Once the node reports again, the status sent before has reached it as well.
        self.assertTrue(rospy.wait_for_message("/diagnostics", DiagnosticArray, TIME_LIMIT_S))

        opened = self.open()
        self.assertTrue(opened.success, opened.message)
        paths = []
        for index in range(TRACES):
            axis.publish(CurrentCoordinate(coordinate=index))
            for _ in range(2):  # the second is the repetition of a call whose answer was lost
                answer = self.store(index)
                self.assertTrue(answer.success, answer.message)
            paths.append(answer.path)
        self.wait_until(
            lambda: len(self.on_disk(opened.path, "/robot1/x_axis/current_coord")) == TRACES,
            "a topic is not recorded to the disk while the survey is open",
        )
        self.check_read(opened.path)
        closed = self.close()
        self.assertTrue(closed.success, closed.message)
        self.assertEqual((closed.stored_traces, closed.path), (TRACES, opened.path))
        self.check_message(
            closed,
            "survey {survey} is closed with {stored} traces",
            {"survey": self.survey_id, "stored": TRACES},
        )

        self.check_read(opened.path)
        expected = [numbers(make_trace(self.survey_id, index)) for index in range(TRACES)]
        self.assertEqual(sorted(glob.glob(opened.path + "/traces/*")), paths)
        files = [json.loads(Path(path).read_text("ascii")) for path in paths]
        self.assertEqual([numbers(one) for one in files], expected)
        bag = self.read_bag(opened.path)
        self.assertEqual([numbers(one) for one in bag["/robot1/trace"]], expected)
        mcap = self.read_mcap(opened.path)
        self.assertEqual([numbers(one) for one in mcap["/robot1/trace"]], expected)
        self.wait_until(lambda: len(live) >= TRACES, "traces are missing on the topic")
        self.assertEqual([numbers(one) for one in live], expected)
        self.check_times(files, bag["/robot1/trace"])
        for recording in (bag, mcap):
            self.check_other_topics(recording)
        self.check_description(opened.path)
        self.replay(opened.path, live, expected)

    def test_1b_the_type_and_the_bytes_are_those_of_ros(self) -> None:
        self.assertEqual(trace_message.MD5SUM, Trace._md5sum)
        self.assertEqual(trace_message.DATATYPE, Trace._type)
        text = (survey_topics.TEXT_TYPE, survey_topics.TEXT_MD5SUM, survey_topics.TEXT_DEFINITION)
        self.assertEqual(text, (String._type, String._md5sum, String._full_text))
        message = make_trace(self.survey_id, 3)
        moments = [message.timestamp, message.sweep_started, message.sweep_ended]
        for moment in (*moments, message.aux[0].stamp):  # the header has that of the trace
            moment.nsecs -= moment.nsecs % 1000  # no form of a trace has more than microseconds
        data = serialized(message)
        self.assertEqual(trace_message.encode(trace_message.decode(data)), data)
        topics = survey_topics.SurveyTopics(Trace._full_text)
        self.assertEqual(topics.metadata("grüße", 1).data, serialized(String("grüße")))

    def check_message(self, answer, template: str, values: dict) -> None:
        record = json.loads(answer.message_json)
        self.assertEqual((record["template"], record["values"]), (template, values))
        self.assertIn(template.format(**values), answer.message)

    def check_times(self, files: list, messages: list) -> None:
        for values, message in zip(files, messages):
            self.assertEqual(values["timestamp"][-13:], ".123456+00:00")
            self.assertEqual(message.timestamp.nsecs, 123_456_000)
            self.assertEqual(message.sweep_ended.nsecs, 123_456_000)

    def check_other_topics(self, recording: dict) -> None:
        statuses = [message.message for message in recording["/robot1/control_status"]]
        self.assertEqual(statuses, ["before the survey", "Finished: by the test"])
        (metadata,) = recording["/robot1/survey_metadata"]
        self.assertEqual(json.loads(metadata.data)["survey_id"], self.survey_id)
        coordinates = [one.coordinate for one in recording["/robot1/x_axis/current_coord"]]
        self.assertEqual(coordinates, list(range(TRACES)))

    def check_description(self, folder: str) -> None:
        with open(folder + "/survey.json", encoding="ascii") as stream:
            survey = json.load(stream)
        self.assertEqual(survey["parameters"], {"x_points": 3})
        self.assertEqual((survey["outcome"], survey["reason"]), ("finished", "by the test"))
        self.assertEqual(survey["stored_traces"], TRACES)

    def read_bag(self, folder: str) -> dict:
        found: dict = {}
        with rosbag.Bag(folder + "/survey.bag") as bag:
            for topic, message, moment in bag.read_messages():
                self.assertGreater(moment.secs, 1_577_836_800)
                found.setdefault(topic, []).append(message)
        return found

    def read_mcap(self, folder: str) -> dict:
        found: dict = {}
        with open(folder + "/survey.mcap", "rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            for _, channel, record, message in reader.iter_decoded_messages():
                self.assertGreater(record.log_time, 1_577_836_800 * 10**9)
                found.setdefault(channel.topic, []).append(message)
        return found

    def on_disk(self, folder: str, topic: str) -> list:
        """Return what a recording that is still open holds of a topic."""
        with open(folder + "/survey.mcap", "rb") as stream:
            reader = NonSeekingReader(stream, decoder_factories=[DecoderFactory()])
            found = []
            try:
                for _, channel, _, message in reader.iter_decoded_messages(log_time_order=False):
                    if channel.topic == topic:
                        found.append(message)
            except (McapError, struct.error):
                return found  # the file has no end yet
        return found

    def replay(self, folder: str, live: list, expected: list) -> None:
        live.clear()
        command = ["rosbag", "play", "--quiet", "--wait-for-subscribers", "--rate=5"]
        topics = ["--topics", "/robot1/trace"]
        subprocess.run(
            [*command, folder + "/survey.bag", *topics], check=True, timeout=TIME_LIMIT_S
        )
        self.wait_until(lambda: len(live) >= TRACES, "the replay brought too few traces")
        self.assertEqual([numbers(one) for one in live], expected)

    def test_10_what_a_publisher_that_has_just_begun_sends_after_the_start_is_recorded(
        self,
    ) -> None:
        for number in range(5):
            self.survey_id = str(uuid.uuid4())
            axis = rospy.Publisher("y_axis/current_coord", CurrentCoordinate, queue_size=10)
            opened = self.open()
            axis.publish(CurrentCoordinate(coordinate=float(number)))
            self.store(0)
            # It comes on its own connection, maybe after the answer to what was asked later.
            self.wait_until(
                lambda path=opened.path: self.on_disk(path, "/robot1/y_axis/current_coord"),
                "the first message of a publisher was not recorded",
            )
            self.assertTrue(self.close().success)
            axis.unregister()
            with rosbag.Bag(f"{opened.path}/survey.bag") as bag:
                topics = [topic for topic, _message, _time in bag.read_messages()]
            self.assertIn("/robot1/y_axis/current_coord", topics)

    def test_11_a_recording_that_is_played_meanwhile_is_not_recorded(self) -> None:
        axis = rospy.Publisher("y_axis/current_coord", CurrentCoordinate, queue_size=10)
        folders = []
        for coordinate in (1.0, 2.0):
            self.survey_id = str(uuid.uuid4())
            opened = self.open()
            self.store(0)
            if folders:
                command = ["rosbag", "play", "--quiet", "--wait-for-subscribers", "--rate=100"]
                before = f"{folders[0]}/survey.bag"
                topics = ["--topics", "/robot1/y_axis/current_coord"]
                subprocess.run([*command, before, *topics], check=True, timeout=TIME_LIMIT_S)
            axis.publish(CurrentCoordinate(coordinate=coordinate))
            self.wait_until(
                lambda path=opened.path: self.on_disk(path, "/robot1/y_axis/current_coord"),
                "the axis was not recorded",
            )
            self.assertTrue(self.close().success)
            folders.append(opened.path)
        for folder, coordinate in zip(folders, (1.0, 2.0)):
            (message,) = self.read_bag(folder)["/robot1/y_axis/current_coord"]
            self.assertEqual(message.coordinate, coordinate)

    def test_2_what_is_wrong_is_answered_with_a_reason_and_leaves_no_trace(self) -> None:
        before = glob.glob(self.data + "/*")
        for changes, code in (
            ({"survey_id": "../../evil"}, "storage.request_refused"),
            ({"metadata_json": "[]"}, "storage.request_refused"),
            ({"metadata_json": "{" * 100_000}, "storage.request_refused"),
            ({"needed_bytes": 1 << 60}, "disk.full"),
            ({"started": rospy.Time(1)}, "clock.wrong"),
        ):
            answer = self.open(**changes)
            self.assertFalse(answer.success)
            self.assertEqual(answer.fault_code, code, answer.message)
        self.assertEqual(glob.glob(self.data + "/*"), before)
        answer = self.store(0)
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault_code, "survey.none_open")

        opened = self.open()
        self.assertTrue(opened.success, opened.message)
        for changes, code in (
            ({"s21_imag": [0.0] * 200}, "vna.wrong_sweep"),
            ({"s21_real": [math.nan] * 201}, "vna.wrong_sweep"),
            ({"frequency_hz": [1.0] * 201}, "vna.wrong_sweep"),
            ({"survey_id": str(uuid.uuid4())}, "survey.other_open"),
            ({"sample_id": "../x"}, "trace.not_allowed"),
            ({"sweep_ended": rospy.Time(0)}, "clock.wrong"),
        ):
            answer = self.store(0, **changes)
            self.assertFalse(answer.success)
            self.assertEqual(answer.fault_code, code, answer.message)
        self.assertEqual(os.listdir(opened.path + "/traces"), [])
        self.assertFalse(self.open(survey_id=str(uuid.uuid4())).success)
        reason = Message("the zero is lost").with_fault(Fault("axis.lost_zero"))
        closed = self.close("failed", reason_json=reason.to_json())
        self.assertEqual((closed.success, closed.stored_traces), (True, 0))
        recording = self.read_bag(opened.path)
        self.assertNotIn("/robot1/trace", recording)
        survey = json.loads(Path(opened.path, "survey.json").read_text("ascii"))
        self.assertEqual((survey["reason"], survey["fault_code"]), (str(reason), "axis.lost_zero"))
        for found in (recording, self.read_mcap(opened.path)):
            last = found["/robot1/control_status"][-1]
            self.assertEqual((last.code, last.fault_code), (ControlStatus.FAILED, "axis.lost_zero"))

    def test_3_the_health_of_the_storage_is_reported(self) -> None:
        opened = self.open()
        self.assertTrue(opened.success, opened.message)
        self.assertTrue(self.store(0).success)
        found = self.collect("/diagnostics", DiagnosticArray)

        def reported() -> bool:
            values = [
                {pair.key: pair.value for pair in status.values}
                for array in list(found)
                for status in array.status
            ]
            return any(
                one.get("open survey") == self.survey_id and one.get("traces stored") == "1"
                for one in values
            )

        self.wait_until(reported, "the diagnostics do not name the survey")
        self.wait_until(
            lambda: self.on_disk(opened.path, "/diagnostics"),
            "the diagnostics are not recorded",
        )
        self.assertTrue(self.close("stopped").success)

    def test_3b_a_data_folder_that_is_gone_is_told_and_never_made_again(self) -> None:
        data = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, data)
        self.start_node("/robot4", data)
        close = self.service("/robot4/close_survey", CloseSurvey)
        self.assertTrue(self.open().success)
        self.assertTrue(close(survey_id=self.survey_id, outcome="stopped").success)
        found = self.collect("/diagnostics", DiagnosticArray)

        def reports(code: str) -> bool:
            own = [one for array in found for one in array.status if "robot4/" in one.name]
            values = {pair.key: pair.value for one in own[-1:] for pair in one.values}
            return values.get("fault_code") == code

        self.wait_until(lambda: reports(""), "a good data folder is not reported")
        os.rename(data, data + "_moved")
        self.wait_until(lambda: reports("storage.other_data_folder"), "nobody says that it is gone")
        self.survey_id = str(uuid.uuid4())
        refused = self.open()
        self.assertFalse(refused.success)
        self.assertIn(data, refused.message)
        self.assertFalse(os.path.exists(data))
        os.rename(data + "_moved", data)
        self.wait_until(lambda: reports(""), "nobody says that the folder is back")

    def test_5_a_node_that_was_killed_continues_the_survey(self) -> None:
        data = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, data)
        first = self.start_node("/robot3", data)
        live = self.collect("/robot3/trace", Trace)
        logged = self.collect("/robot3/survey_log", String)
        opened = self.open()
        self.assertTrue(opened.success, opened.message)
        for index in range(3):
            self.assertTrue(self.store(index).success)
        report = self.services["report_survey"]
        self.assertTrue(report(self.survey_id, '{"verdict": "INCOMPLETE"}').success)
        self.assertFalse(report(str(uuid.uuid4()), "{}").success)
        self.wait_until(lambda: logged, "the report is not published")
        self.assertEqual(json.loads(logged[0].data)["values"], {"verdict": "INCOMPLETE"})
        self.wait_until(lambda: len(live) == 3, "traces are missing on the topic")
        first.kill()
        first.wait(TIME_LIMIT_S)

        second = self.start_node("/robot3", data)
        for name in ("../x", "/etc", str(uuid.uuid4())):
            self.assertFalse(self.services["reopen_survey"](survey=name).success)
        for name in (self.survey_id, os.path.basename(opened.path)):
            answer = self.services["reopen_survey"](survey=name)
            self.assertTrue(answer.success, answer.message)
            self.assertEqual((answer.path, answer.survey_id), (opened.path, self.survey_id))
            self.assertEqual(answer.stored_indices, (0, 1, 2))
            self.assertEqual(numbers(answer.recent[-1]), numbers(make_trace(self.survey_id, 2)))
            self.assertEqual(json.loads(answer.metadata_json), {"parameters": {"x_points": 3}})
            self.assertEqual(json.loads(answer.report_json), {"verdict": "INCOMPLETE"})
        for index in range(2, TRACES):
            # Index 2 is stored already, with another time: it is left as it is.
            answer = self.store(index, timestamp=rospy.Time(1_790_000_000 + index))
            self.assertEqual(answer.success, index > 2, answer.message)
        # The process that was killed may not have published the last one: it comes again, once.
        published = [0, 1, 2, *range(2, TRACES)]
        self.wait_until(lambda: len(live) >= len(published), "traces are missing on the topic")
        self.assertEqual([trace.index for trace in live], published)
        self.assertEqual(live[2].sample_id, live[3].sample_id)
        close = self.service("/robot3/close_survey", CloseSurvey)
        closed = close(survey_id=self.survey_id, outcome="finished", reason="by the test")
        self.assertEqual((closed.success, closed.stored_traces), (True, TRACES), closed.message)
        for found in (self.read_bag(opened.path), self.read_mcap(opened.path)):
            indices = [message.index for message in found["/robot3/trace"]]
            self.assertEqual(indices, list(range(TRACES)))
            kinds = [json.loads(one.data)["kind"] for one in found["/robot3/survey_log"]]
            # The second request came before anything was stored: it is the same resumption.
            self.assertEqual(kinds, ["plan", "report", "resume"])
        refused = self.services["reopen_survey"](survey=self.survey_id)
        self.assertFalse(refused.success)
        self.assertEqual(refused.fault_code, "survey.complete")
        second.send_signal(signal.SIGINT)
        second.wait(TIME_LIMIT_S)

    def test_6_a_survey_begun_with_other_message_definitions_is_resumed(self) -> None:
        data = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, data)
        first = self.start_node("/robot4", data)
        old = rospy.Publisher("/robot4/control_status", old_status_class(), queue_size=1)
        self.connected(old)
        opened = self.open()
        self.assertTrue(opened.success, opened.message)
        old.publish(message="old")
        self.assertTrue(self.store(0).success)
        name = "/robot4/control_status"
        self.wait_until(lambda: self.on_disk(opened.path, name), "the status is not recorded")
        first.kill()
        first.wait(TIME_LIMIT_S)
        old.unregister()

        second = self.start_node("/robot4", data)
        new = self.connected(rospy.Publisher(name, ControlStatus, queue_size=1))
        answer = self.services["reopen_survey"](survey=self.survey_id)
        self.assertTrue(answer.success, answer.message)
        new.publish(ControlStatus(message="new", message_json="{}"))
        renamed = f"{name}_{ControlStatus._md5sum[:8]}"
        self.wait_until(lambda: self.on_disk(opened.path, renamed), "the status is not recorded")
        self.assertTrue(self.store(1).success)
        close = self.service("/robot4/close_survey", CloseSurvey)
        closed = close(survey_id=self.survey_id, outcome="stopped", reason="by the test")
        self.assertTrue(closed.success, closed.message)
        second.send_signal(signal.SIGINT)
        second.wait(TIME_LIMIT_S)
        new.unregister()
        for found in (self.read_bag(opened.path), self.read_mcap(opened.path)):
            self.assertEqual([one.index for one in found["/robot4/trace"]], [0, 1])
            self.assertEqual([one.message for one in found[name]], ["old"])
            recorded, end = found[renamed]
            self.assertEqual((recorded.message_json, end.code), ("{}", ControlStatus.STOPPED))
        self.check_play(f"{opened.path}/survey.bag", name, old_status_class(), "old")
        self.check_play(f"{opened.path}/survey.bag", renamed, ControlStatus, "new")

    def check_play(self, bag: str, topic: str, kind, text: str) -> None:
        found: list = []
        subscriber = rospy.Subscriber(topic, kind, found.append)
        command = ["rosbag", "play", "--quiet", "--wait-for-subscribers", "--rate=100", bag]
        subprocess.run([*command, "--topics", topic], check=True, timeout=TIME_LIMIT_S)
        self.wait_until(lambda: found, f"rosbag does not play {topic}")
        subscriber.unregister()
        # The storage's own status, the last one, may follow.
        self.assertEqual(found[0].message, text)

    def start_node(self, namespace: str, data: str) -> subprocess.Popen:
        node = subprocess.Popen(
            [sys.executable, str(NODE), f"__ns:={namespace}"],
            env={**os.environ, "GPR20_DATA": data},
        )
        self.addCleanup(node.kill)
        # The master still knows the services of a node that was killed: ask until one answers.
        loggers = rospy.ServiceProxy(f"{namespace}/vna_processing/get_loggers", GetLoggers)
        self.wait_until(lambda: self.answers(loggers), "the node does not start")
        for name, kind in (
            ("open_survey", OpenSurvey),
            ("reopen_survey", ReopenSurvey),
            ("report_survey", ReportSurvey),
            ("store_data", StoreData),
        ):
            self.services[name] = self.service(f"{namespace}/{name}", kind)
        return node

    def answers(self, proxy: rospy.ServiceProxy) -> bool:
        try:
            proxy()
        except rospy.ServiceException:
            return False
        return True

    def test_4_a_node_that_is_stopped_finishes_the_recordings(self) -> None:
        data = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, data)
        node = subprocess.Popen(
            [sys.executable, str(NODE), "__ns:=/robot2"],
            env={**os.environ, "GPR20_DATA": data},
        )
        self.addCleanup(node.kill)
        self.services["open_survey"] = self.service("/robot2/open_survey", OpenSurvey)
        self.services["store_data"] = self.service("/robot2/store_data", StoreData)
        opened = self.open()
        self.assertTrue(self.store(0).success)
        node.send_signal(signal.SIGINT)
        node.wait(TIME_LIMIT_S)
        with open(opened.path + "/survey.json", encoding="ascii") as stream:
            survey = json.load(stream)
        self.assertEqual((survey["outcome"], survey["stored_traces"]), ("interrupted", 1))
        self.assertEqual(len(self.read_bag(opened.path)["/robot2/trace"]), 1)
        for found in (self.read_bag(opened.path), self.read_mcap(opened.path)):
            end = found["/robot2/control_status"][-1]
            self.assertEqual((end.code, end.survey_id), (ControlStatus.FAILED, self.survey_id))
            self.assertEqual(end.message, "Interrupted before its end: the storage was shut down")
            (mark,) = found["/robot2/replay"]
            self.assertEqual(mark.survey_id, self.survey_id)
        self.assertEqual(len(self.read_mcap(opened.path)["/robot2/trace"]), 1)


def old_status_class() -> type:
    return genpy.dynamic.generate_dynamic("gpr20_msgs/ControlStatus", OLD_STATUS)[
        "gpr20_msgs/ControlStatus"
    ]


if __name__ == "__main__":
    import rostest

    rospy.init_node("test_store_survey")
    rostest.rosrun(PACKAGE, "store_survey", StoreSurveyTest, sys.argv)
