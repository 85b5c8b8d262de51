#!/usr/bin/env python3
"""Surveys stored through the services of the running node: what only a graph can show."""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import uuid
from pathlib import Path

import numpy as np
import rosbag
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory
from roscpp.srv import GetLoggers

from gpr20_common.high.answers import fault_of
from gpr20_common.high.raw_message import deserialized
from gpr20_common.message import Fault, Message
from gpr20_msgs.msg import ControlStatus, CurrentCoordinate, Trace
from gpr20_msgs.srv import (
    AddFact,
    CloseSurvey,
    OpenSurvey,
    ReadTraces,
    ReopenSurvey,
    StoreData,
)
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import AuxValue

sys.path.append(str(Path(__file__).resolve().parents[5] / "tools/kits"))
from trace_examples import assert_same_numbers, make_trace
from wait_kit import wait_until

PACKAGE = "gpr20_vna_processing"
NODE = Path(__file__).resolve().parents[2] / "nodes" / "vna_processing"
SERVICES = {
    "open_survey": OpenSurvey,
    "reopen_survey": ReopenSurvey,
    "add_fact": AddFact,
    "store_data": StoreData,
    "close_survey": CloseSurvey,
    "read_traces": ReadTraces,
}
TIME_LIMIT_S = 200.0
TRACES = 6
MEASURED_US = (math.floor(time.time()) - 1) * 10**6


def trace_of(survey_id: str, index: int):
    """Return a trace; one that is sent again must be the very same."""
    times_us = (MEASURED_US + 123_456, MEASURED_US, MEASURED_US + 123_456)
    return make_trace(
        index,
        survey_id=survey_id,
        x_coord_mm=50.0 * index,
        antennae_height_m=math.nan if index == 0 else 0.1 * index,
        quality=("level low",) if index == 2 else (),
        aux=(AuxValue("soil", 0.1 * index, "m3/m3", MEASURED_US),) if index % 2 else (),
        **dict(zip(("timestamp_us", "sweep_started_us", "sweep_ended_us"), times_us)),
    )


def sent(survey_id: str, index: int, **changes) -> Trace:
    """Return a trace as the control sends it."""
    trace = deserialized(Trace, trace_message.encode(trace_of(survey_id, index)))
    trace.timestamp.nsecs += 789  # nanoseconds are cut off everywhere
    for name, value in changes.items():
        setattr(trace, name, value)
    trace.header.stamp = trace.timestamp
    return trace


def recordings(folder: str) -> list:
    """Return the messages by topic that the stock readers find in the bag and in the MCAP."""
    bag_topics: dict = {}
    mcap_topics: dict = {}
    wait_until(Path(folder, "survey.bag").exists)
    with rosbag.Bag(folder + "/survey.bag") as bag:
        for topic, message, _ in bag.read_messages():
            bag_topics.setdefault(topic, []).append(message)
    with open(folder + "/survey.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            mcap_topics.setdefault(channel.topic, []).append(message)
    return [bag_topics, mcap_topics]


def on_disk(folder: str, topic: str) -> list:
    """Return what a recording that is still open holds of a topic."""
    return [one for one in StoredMcap(Path(folder, "survey.mcap")).messages() if one.topic == topic]


def description_in(folder: str) -> dict:
    return read_description(Path(folder))


class StoreSurveyTest(unittest.TestCase):
    @classmethod
    def tearDownClass(cls) -> None:
        shutil.rmtree(rospy.get_param("~data"))

    def setUp(self) -> None:
        self.survey_id = str(uuid.uuid4())
        self.find_services(rospy.get_namespace())
        # A test that failed half way must not fail the next ones.
        close = self.services["close_survey"]
        self.addCleanup(lambda: close(survey_id=self.survey_id, outcome="failed"))

    def find_services(self, namespace: str) -> None:
        self.services = {}
        for name, kind in SERVICES.items():
            rospy.wait_for_service(f"{namespace}{name}", TIME_LIMIT_S)
            self.services[name] = rospy.ServiceProxy(f"{namespace}{name}", kind)

    def assert_stored(self, found, survey_id: str) -> None:
        self.assertEqual(len(found), TRACES)
        for index, one in enumerate(found):
            assert_same_numbers(trace_of(survey_id, index), one)

    def done(self, answer):
        self.assertTrue(answer.success, answer.message)
        return answer

    def open(self, **changes):
        request = {
            "survey_id": self.survey_id,
            "started": rospy.Time.now(),
            "metadata_json": '{"parameters": {"x_points": 3}}',
            "needed_bytes": 1_000_000,
        }
        return self.services["open_survey"](**{**request, **changes})

    def store(self, index: int, **changes):
        return self.services["store_data"](sent(self.survey_id, index, **changes))

    def close(self, outcome: str = "finished", **more):
        request = {"survey_id": self.survey_id, "outcome": outcome, "reason": "by the test"}
        return self.services["close_survey"](**request, **more)

    def collect(self, topic: str, kind) -> list:
        found: list = []
        subscriber = rospy.Subscriber(topic, kind, found.append)
        self.addCleanup(subscriber.unregister)
        wait_until(lambda: subscriber.get_num_connections() > 0, f"no publisher of {topic}")
        return found

    def wait_for_health(self, found: list, node: str, **expected: str) -> None:
        """Wait until the diagnostics of a storage say something."""

        def is_said() -> bool:
            own = [one for array in list(found) for one in array.status if node in one.name]
            values = [{pair.key: pair.value for pair in one.values} for one in own[-1:]]
            values = [{**one, **json.loads(one["fault"])} for one in values]
            return any(expected.items() <= one.items() for one in values)

        wait_until(is_said, f"the diagnostics do not say {expected}")

    def test_1_a_survey_is_the_same_in_json_bag_mcap_and_topic(self) -> None:
        status = rospy.Publisher("control_status", ControlStatus, queue_size=1, latch=True)
        status.publish(ControlStatus(code=ControlStatus.SURVEYING, message="before the survey"))
        wait_until(lambda: status.get_num_connections() > 0, "nobody records the topic")
        live = self.collect("trace", Trace)
        health = self.collect("/diagnostics", DiagnosticArray)
        # Once the node reports again, the status sent before has reached it as well.
        wait_until(lambda: health, "the node says nothing of its health")
        # What a publisher that has just begun sends after the start is recorded.
        axis = rospy.Publisher("x_axis/current_coord", CurrentCoordinate, queue_size=10)
        opened = self.done(self.open())
        paths = []
        for index in range(TRACES):
            axis.publish(CurrentCoordinate(coordinate=index))
            for _ in range(2):  # the second is the repetition of a call whose answer was lost
                answer = self.done(self.store(index))
            paths.append(answer.path)
        topic = "/robot1/x_axis/current_coord"
        wait_until(
            lambda: len(on_disk(opened.path, topic)) == TRACES,
            "a topic is not recorded to the disk while the survey is open",
        )
        self.wait_for_health(
            health, "robot1/", **{"open survey": self.survey_id, "traces stored": str(TRACES)}
        )
        self.check_read(self.survey_id)
        closed = self.done(self.close())
        self.assertEqual(
            json.loads(closed.fault.values),
            {"survey": self.survey_id, "stored": TRACES},
        )
        self.check_read(Path(opened.path).name)
        files = [json.loads(Path(path).read_text("ascii")) for path in paths]
        self.assertEqual(sorted(map(str, Path(opened.path, "traces").iterdir())), paths)
        wait_until(lambda: len(live) >= TRACES, "traces are missing on the topic")
        for found in (files, live):
            self.assert_stored(found, self.survey_id)
        for recording in recordings(opened.path):
            self.assert_stored(recording["/robot1/trace"], self.survey_id)
            self.assertEqual(recording["/robot1/trace"][0].timestamp.nsecs, 123_456_000)
            statuses = [one.message for one in recording["/robot1/control_status"]]
            self.assertEqual(statuses, ["before the survey", "Finished: by the test"])
            (metadata,) = recording["/robot1/survey_metadata"]
            self.assertEqual(json.loads(metadata.data)["survey_id"], self.survey_id)
            coordinates = [one.coordinate for one in recording[topic]]
            self.assertEqual(coordinates, list(range(TRACES)))
            self.assertIn("/diagnostics", recording)
        self.assertEqual(files[0]["timestamp"][-13:], ".123456+00:00")
        self.assertEqual(description_in(opened.path)["parameters"], {"x_points": 3})
        self.check_replay(opened.path, live)

    def check_read(self, survey: str) -> None:
        """Compare what `read_traces` returns with what was stored."""
        answer = self.done(
            self.services["read_traces"](survey=survey, indices=[*range(TRACES), TRACES + 1])
        )
        stored = [trace_of(self.survey_id, index) for index in range(TRACES)]
        self.assertEqual((answer.survey_id, answer.indices), (self.survey_id, (*range(TRACES),)))
        self.assertEqual(answer.x_coord_mm, tuple(one.x_coord_mm for one in stored))
        own = [one.s21_real + 1j * one.s21_imag for one in stored]
        self.assertEqual(answer.s21, np.array(own).astype("<c8").tobytes())
        (unreadable,) = answer.unreadable
        self.assertIn(str(TRACES + 1), unreadable)

    def check_replay(self, folder: str, live: list) -> None:
        """Play the bag while another survey is open, which does not record what is played."""
        live.clear()
        played = self.survey_id
        self.survey_id = str(uuid.uuid4())
        opened = self.done(self.open())
        command = ["rosbag", "play", "--quiet", "--wait-for-subscribers", "--rate=20"]
        topics = ["--topics", "/robot1/trace", "/robot1/x_axis/current_coord"]
        subprocess.run(
            [*command, folder + "/survey.bag", *topics], check=True, timeout=TIME_LIMIT_S
        )
        wait_until(lambda: len(live) >= TRACES, "the replay brought too few traces")
        self.assert_stored(live, played)
        self.done(self.close("stopped"))
        self.assertNotIn("/robot1/x_axis/current_coord", recordings(opened.path)[0])

    def test_2_what_is_wrong_is_answered_with_its_fault_and_leaves_no_trace(self) -> None:
        self.assertEqual(self.store(0).fault.code, "survey.none_open")
        opened = self.done(self.open())
        answer = self.store(0, sweep_ended=rospy.Time(0))
        self.assertEqual((answer.success, answer.fault.code), (False, "clock.wrong"))
        self.assertEqual(os.listdir(opened.path + "/traces"), [])
        reason = Message("the zero is lost").with_fault(Fault("axis.lost_zero"))
        self.done(self.close("failed", reason_fault=fault_of(reason)))
        survey = description_in(opened.path)
        self.assertEqual((survey["reason"], survey["fault_code"]), (str(reason), "axis.lost_zero"))
        for found in recordings(opened.path):
            self.assertNotIn("/robot1/trace", found)
            last = found["/robot1/control_status"][-1]
            self.assertEqual((last.code, last.fault.code), (ControlStatus.FAILED, "axis.lost_zero"))

    def test_3_a_node_that_was_killed_continues_the_survey(self) -> None:
        data = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, data)
        first = self.start_node(data)
        live = self.collect("/robot3/trace", Trace)
        opened = self.done(self.open())
        for index in range(3):
            self.done(self.store(index))
        add_fact = self.services["add_fact"]
        report = self.survey_id, "report", '{"verdict": "INCOMPLETE"}'
        self.assertEqual(self.done(add_fact(*report)).stored_traces, 3)
        self.assertEqual(add_fact("", "end", "{}").fault.code, "value.not_allowed")
        wait_until(lambda: len(live) == 3, "traces are missing on the topic")
        first.kill()
        first.wait(TIME_LIMIT_S)

        second = self.start_node(data)
        self.assertFalse(self.services["reopen_survey"](survey="../x").success)
        answer = self.done(self.services["reopen_survey"](survey=self.survey_id))
        self.assertEqual((answer.survey_id, answer.stored_indices), (self.survey_id, (0, 1, 2)))
        assert_same_numbers(trace_of(self.survey_id, 2), answer.recent[-1])
        self.assertEqual(json.loads(answer.metadata_json), {"parameters": {"x_points": 3}})
        self.assertEqual(json.loads(answer.report_json), {"verdict": "INCOMPLETE"})
        for index in range(2, TRACES):
            # Index 2 is stored already, with another time: it is left as it is.
            answer = self.store(index, timestamp=rospy.Time(1_790_000_000 + index))
            self.assertEqual(answer.success, index > 2, answer.message)
        # The process that was killed may not have published the last one: it comes again, once.
        published = [0, 1, 2, *range(2, TRACES)]
        wait_until(lambda: len(live) >= len(published), "traces are missing on the topic")
        self.assertEqual([trace.index for trace in live], published)
        self.assertEqual(live[2].sample_id, live[3].sample_id)
        self.done(self.close())
        for found in recordings(opened.path):
            indices = [message.index for message in found["/robot3/trace"]]
            self.assertEqual(indices, list(range(TRACES)))
            kinds = [json.loads(one.data)["kind"] for one in found["/robot3/survey_log"]]
            self.assertEqual(kinds, ["plan", "report", "resume"])
        self.check_ended_by_signal(second)

    def start_node(self, data: str) -> subprocess.Popen:
        node = subprocess.Popen(
            [sys.executable, str(NODE), "__ns:=/robot3"],
            env={**os.environ, "GPR20_DATA": data},
        )
        self.addCleanup(node.kill)
        # The master still knows the services of a node that was killed: ask until one answers.
        loggers = rospy.ServiceProxy("/robot3/vna_processing/get_loggers", GetLoggers)
        wait_until(lambda: self.answers(loggers), "the node does not start")
        self.find_services("/robot3/")
        return node

    def answers(self, proxy: rospy.ServiceProxy) -> bool:
        try:
            proxy()
        except rospy.ServiceException:
            return False
        return True

    def check_ended_by_signal(self, node: subprocess.Popen) -> None:
        """A node that is stopped finishes the recordings."""
        self.survey_id = str(uuid.uuid4())
        opened = self.done(self.open())
        self.done(self.store(0))
        node.send_signal(signal.SIGINT)
        node.wait(TIME_LIMIT_S)
        survey = description_in(opened.path)
        self.assertEqual((survey["outcome"], survey["stored_traces"]), ("interrupted", 1))
        for found in recordings(opened.path):
            self.assertEqual(len(found["/robot3/trace"]), 1)
            end = found["/robot3/control_status"][-1]
            self.assertEqual((end.code, end.survey_id), (ControlStatus.FAILED, self.survey_id))
            (mark,) = found["/robot3/replay"]
            self.assertEqual(mark.survey_id, self.survey_id)


if __name__ == "__main__":
    import rostest

    rospy.init_node("test_store_survey")
    rostest.rosrun(PACKAGE, "store_survey", StoreSurveyTest, sys.argv)
