#!/usr/bin/env python3
"""Surveys stored through the services of the running node: what only a graph can show."""

from __future__ import annotations

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
from types import MappingProxyType

import numpy as np
import rosbag
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros1.decoder import DecoderFactory
from roscpp.srv import GetLoggers
from std_msgs.msg import Header, String

from gpr20_common.message import Fault, Message
from gpr20_msgs.msg import AuxValue, ControlStatus, CurrentCoordinate, Trace
from gpr20_msgs.srv import (
    CloseSurvey,
    OpenSurvey,
    ReadTraces,
    ReopenSurvey,
    ReportSurvey,
    StoreData,
)
from gpr20_survey.frames import ANTENNA_LINK

PACKAGE = "gpr20_vna_processing"
NODE = Path(__file__).resolve().parents[2] / "nodes" / "vna_processing"
SERVICES = {
    "open_survey": OpenSurvey,
    "reopen_survey": ReopenSurvey,
    "report_survey": ReportSurvey,
    "store_data": StoreData,
    "close_survey": CloseSurvey,
    "read_traces": ReadTraces,
}
TIME_LIMIT_S = 60.0
TRACES = 6
# One moment for all: a trace that is sent again must be the very same.
MEASURED_S = math.floor(time.time()) - 1


def make_trace(survey_id: str, index: int, changes=MappingProxyType({})) -> Trace:
    now = rospy.Time(MEASURED_S)
    later = rospy.Time(now.secs, 123_456_789)  # nanoseconds are cut off everywhere
    trace = Trace(
        header=Header(seq=index, frame_id=ANTENNA_LINK),
        format="gpr20-trace/1",
        survey_id=survey_id,
        sample_id=f"{survey_id}-{index:06d}",
        index=index,
        timestamp=later,
        x_coord_mm=50.0 * index,
        y_coord_mm=50.0,
        z_coord_deg=90.0 * (index % 2),
        antennae_height_m=math.nan if index == 0 else 0.1 * index,
        frequency_hz=[600e6 + 512.0 * k for k in range(201)],
        s21_real=[math.sin(k + index) * 1e-3 for k in range(201)],
        s21_imag=[math.cos(k + index) * 1e-300 for k in range(201)],
        sweep_started=now,
        sweep_ended=later,
        quality=["level low"] if index == 2 else [],
        aux=[AuxValue("soil_moisture", 0.1 * index, "m3/m3", later)] if index % 2 else [],
    )
    for name, value in changes.items():
        setattr(trace, name, value)
    trace.header.stamp = trace.timestamp
    return trace


def numbers(trace) -> tuple:
    """Return what must be the same in JSON, bag, MCAP and topic."""
    get = trace.get if isinstance(trace, dict) else lambda name: getattr(trace, name)
    height = get("antennae_height_m")
    return (
        *(get(name) for name in ("index", "sample_id", "x_coord_mm", "y_coord_mm", "z_coord_deg")),
        None if height is None or math.isnan(height) else height,
        *(tuple(get(name)) for name in ("frequency_hz", "s21_real", "s21_imag", "quality")),
        *(
            (one["name"], one["value"]) if isinstance(one, dict) else (one.name, one.value)
            for one in get("aux") or ()
        ),
    )


def in_bag(folder: str) -> dict:
    """Return the messages that the stock reader finds, by topic."""
    found: dict = {}
    with rosbag.Bag(folder + "/survey.bag") as bag:
        for topic, message, _ in bag.read_messages():
            found.setdefault(topic, []).append(message)
    return found


def in_mcap(folder: str) -> dict:
    found: dict = {}
    with open(folder + "/survey.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append(message)
    return found


def on_disk(folder: str, topic: str) -> list:
    """Return what a recording that is still open holds of a topic."""
    found = []
    with open(folder + "/survey.mcap", "rb") as stream:
        reader = NonSeekingReader(stream, decoder_factories=[DecoderFactory()])
        try:
            for _, channel, _, message in reader.iter_decoded_messages(log_time_order=False):
                if channel.topic == topic:
                    found.append(message)
        except (McapError, struct.error):
            return found  # the file has no end yet
    return found


def survey_json(folder: str) -> dict:
    return json.loads(Path(folder, "survey.json").read_text("ascii"))


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

    def wait_until(self, condition, what: str) -> None:
        deadline_s = time.monotonic() + TIME_LIMIT_S
        while not condition():
            self.assertLess(time.monotonic(), deadline_s, what)
            time.sleep(0.02)

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

    def wait_for_health(self, found: list, node: str, **expected: str) -> None:
        """Wait until the diagnostics of a storage say something."""

        def is_said() -> bool:
            own = [one for array in list(found) for one in array.status if node in one.name]
            values = [{pair.key: pair.value for pair in one.values} for one in own[-1:]]
            return any(expected.items() <= one.items() for one in values)

        self.wait_until(is_said, f"the diagnostics do not say {expected}")

    def test_1_a_survey_is_the_same_in_json_bag_mcap_and_topic(self) -> None:
        status = rospy.Publisher("control_status", ControlStatus, queue_size=1, latch=True)
        status.publish(ControlStatus(code=ControlStatus.SURVEYING, message="before the survey"))
        self.connected(status)
        live = self.collect("trace", Trace)
        health = self.collect("/diagnostics", DiagnosticArray)
        # Once the node reports again, the status sent before has reached it as well.
        self.wait_until(lambda: health, "the node says nothing of its health")
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
        self.wait_until(
            lambda: len(on_disk(opened.path, topic)) == TRACES,
            "a topic is not recorded to the disk while the survey is open",
        )
        self.wait_for_health(
            health, "robot1/", **{"open survey": self.survey_id, "traces stored": str(TRACES)}
        )
        self.check_read(self.survey_id)
        closed = self.done(self.close())
        self.assertEqual((closed.stored_traces, closed.path), (TRACES, opened.path))
        self.assertEqual(
            json.loads(closed.message_json)["values"],
            {"survey": self.survey_id, "stored": TRACES},
        )
        self.check_read(Path(opened.path).name)
        expected = [numbers(make_trace(self.survey_id, index)) for index in range(TRACES)]
        files = [json.loads(Path(path).read_text("ascii")) for path in paths]
        self.assertEqual(sorted(map(str, Path(opened.path, "traces").iterdir())), paths)
        self.wait_until(lambda: len(live) >= TRACES, "traces are missing on the topic")
        recordings = in_bag(opened.path), in_mcap(opened.path)
        for found in (files, live, *(one["/robot1/trace"] for one in recordings)):
            self.assertEqual([numbers(one) for one in found], expected)
        for recording in recordings:
            self.assertEqual(recording["/robot1/trace"][0].timestamp.nsecs, 123_456_000)
            statuses = [one.message for one in recording["/robot1/control_status"]]
            self.assertEqual(statuses, ["before the survey", "Finished: by the test"])
            (metadata,) = recording["/robot1/survey_metadata"]
            self.assertEqual(json.loads(metadata.data)["survey_id"], self.survey_id)
            coordinates = [one.coordinate for one in recording[topic]]
            self.assertEqual(coordinates, list(range(TRACES)))
            self.assertIn("/diagnostics", recording)
        self.assertEqual(files[0]["timestamp"][-13:], ".123456+00:00")
        self.assertEqual(survey_json(opened.path)["parameters"], {"x_points": 3})
        self.check_replay(opened.path, live, expected)

    def check_read(self, survey: str) -> None:
        """Compare what `read_traces` returns with what was stored."""
        answer = self.done(
            self.services["read_traces"](survey=survey, indices=[*range(TRACES), TRACES + 1])
        )
        stored = [make_trace(self.survey_id, index) for index in range(TRACES)]
        self.assertEqual((answer.survey_id, answer.indices), (self.survey_id, (*range(TRACES),)))
        self.assertEqual(answer.x_coord_mm, tuple(one.x_coord_mm for one in stored))
        own = [np.array(one.s21_real) + 1j * np.array(one.s21_imag) for one in stored]
        self.assertEqual(answer.s21, np.array(own).astype("<c8").tobytes())
        (unreadable,) = answer.unreadable
        self.assertIn(str(TRACES + 1), unreadable)

    def check_replay(self, folder: str, live: list, expected: list) -> None:
        """Play the bag while another survey is open, which does not record what is played."""
        live.clear()
        self.survey_id = str(uuid.uuid4())
        opened = self.done(self.open())
        command = ["rosbag", "play", "--quiet", "--wait-for-subscribers", "--rate=20"]
        topics = ["--topics", "/robot1/trace", "/robot1/x_axis/current_coord"]
        subprocess.run(
            [*command, folder + "/survey.bag", *topics], check=True, timeout=TIME_LIMIT_S
        )
        self.wait_until(lambda: len(live) >= TRACES, "the replay brought too few traces")
        self.assertEqual([numbers(one) for one in live], expected)
        self.done(self.close("stopped"))
        self.assertNotIn("/robot1/x_axis/current_coord", in_bag(opened.path))

    def test_2_what_is_wrong_is_answered_with_its_fault_and_leaves_no_trace(self) -> None:
        before = os.listdir(rospy.get_param("~data"))
        for changes, code in (
            ({"survey_id": "../../evil"}, "storage.request_refused"),
            ({"metadata_json": "{" * 100_000}, "storage.request_refused"),
            ({"needed_bytes": 1 << 60}, "disk.full"),
            ({"started": rospy.Time(1)}, "clock.wrong"),
        ):
            answer = self.open(**changes)
            self.assertEqual((answer.success, answer.fault_code), (False, code), answer.message)
        self.assertEqual(os.listdir(rospy.get_param("~data")), before)
        self.assertEqual(self.store(0).fault_code, "survey.none_open")
        opened = self.done(self.open())
        for changes, code in (
            ({"s21_real": [math.nan] * 201}, "vna.wrong_sweep"),
            ({"survey_id": str(uuid.uuid4())}, "survey.other_open"),
            ({"sample_id": "../x"}, "trace.not_allowed"),
            ({"sweep_ended": rospy.Time(0)}, "clock.wrong"),
        ):
            answer = self.store(0, **changes)
            self.assertEqual((answer.success, answer.fault_code), (False, code), answer.message)
        self.assertEqual(os.listdir(opened.path + "/traces"), [])
        self.assertFalse(self.open(survey_id=str(uuid.uuid4())).success)
        reason = Message("the zero is lost").with_fault(Fault("axis.lost_zero"))
        closed = self.done(self.close("failed", reason_json=reason.to_json()))
        self.assertEqual(closed.stored_traces, 0)
        survey = survey_json(opened.path)
        self.assertEqual((survey["reason"], survey["fault_code"]), (str(reason), "axis.lost_zero"))
        for found in (in_bag(opened.path), in_mcap(opened.path)):
            self.assertNotIn("/robot1/trace", found)
            last = found["/robot1/control_status"][-1]
            self.assertEqual((last.code, last.fault_code), (ControlStatus.FAILED, "axis.lost_zero"))

    def test_3_a_node_that_was_killed_continues_the_survey(self) -> None:
        data = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, data)
        first = self.start_node(data)
        live = self.collect("/robot3/trace", Trace)
        logged = self.collect("/robot3/survey_log", String)
        opened = self.done(self.open())
        for index in range(3):
            self.done(self.store(index))
        self.done(self.services["report_survey"](self.survey_id, '{"verdict": "INCOMPLETE"}'))
        self.wait_until(lambda: logged, "the report is not published")
        self.assertEqual(json.loads(logged[0].data)["values"], {"verdict": "INCOMPLETE"})
        self.wait_until(lambda: len(live) == 3, "traces are missing on the topic")
        first.kill()
        first.wait(TIME_LIMIT_S)

        second = self.start_node(data)
        self.check_moved_data(data)
        for name in ("../x", str(uuid.uuid4())):
            self.assertFalse(self.services["reopen_survey"](survey=name).success)
        for name in (self.survey_id, os.path.basename(opened.path)):
            answer = self.done(self.services["reopen_survey"](survey=name))
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
        self.assertEqual(self.done(self.close()).stored_traces, TRACES)
        for found in (in_bag(opened.path), in_mcap(opened.path)):
            indices = [message.index for message in found["/robot3/trace"]]
            self.assertEqual(indices, list(range(TRACES)))
            kinds = [json.loads(one.data)["kind"] for one in found["/robot3/survey_log"]]
            # The second request came before anything was stored: it is the same resumption.
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
        self.wait_until(lambda: self.answers(loggers), "the node does not start")
        self.find_services("/robot3/")
        return node

    def answers(self, proxy: rospy.ServiceProxy) -> bool:
        try:
            proxy()
        except rospy.ServiceException:
            return False
        return True

    def check_moved_data(self, data: str) -> None:
        """A data folder that is gone is told, and never made again."""
        found = self.collect("/diagnostics", DiagnosticArray)
        os.rename(data, data + "_moved")
        self.wait_for_health(found, "robot3/", fault_code="storage.other_data_folder")
        self.assertFalse(self.open(survey_id=str(uuid.uuid4())).success)
        self.assertFalse(os.path.exists(data))
        os.rename(data + "_moved", data)

    def check_ended_by_signal(self, node: subprocess.Popen) -> None:
        """A node that is stopped finishes the recordings."""
        self.survey_id = str(uuid.uuid4())
        opened = self.done(self.open())
        self.done(self.store(0))
        node.send_signal(signal.SIGINT)
        node.wait(TIME_LIMIT_S)
        survey = survey_json(opened.path)
        self.assertEqual((survey["outcome"], survey["stored_traces"]), ("interrupted", 1))
        for found in (in_bag(opened.path), in_mcap(opened.path)):
            self.assertEqual(len(found["/robot3/trace"]), 1)
            end = found["/robot3/control_status"][-1]
            self.assertEqual((end.code, end.survey_id), (ControlStatus.FAILED, self.survey_id))
            (mark,) = found["/robot3/replay"]
            self.assertEqual(mark.survey_id, self.survey_id)


if __name__ == "__main__":
    import rostest

    rospy.init_node("test_store_survey")
    rostest.rosrun(PACKAGE, "store_survey", StoreSurveyTest, sys.argv)
