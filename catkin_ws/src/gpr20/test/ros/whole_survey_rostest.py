#!/usr/bin/env python3
"""A survey through the whole graph: what is said, shown and stored."""

import json
import re
import shutil
import threading
import unittest
import uuid
from collections import defaultdict

import numpy as np
import rosbag
import roslib.message
import rospy
import rostest
from mcap_ros1.reader import read_ros1_messages
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image
from std_msgs.msg import String
from survey_client import (
    LIMIT_S,
    SurveyClient,
    bits,
    json_traces,
    wait_for_bag,
)
from tf2_msgs.msg import TFMessage

from gpr20_analysis.read.verification import verify_survey
from gpr20_msgs.msg import Annotation, ControlStatus
from gpr20_msgs.srv import AddFact, ExportSurvey, FocusSurvey
from gpr20_survey import axes as frames
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan import annotation
from gpr20_survey.plan.annotation import Wgs84Position
from gpr20_survey.plan.markers import Marker, present_markers
from gpr20_survey.results.candidates import NO_CLEARANCE

# Of a user's own node; extra_topic/storage.yaml names it.
OWN_TOPIC = "/soil_probe/moisture"
# What nobody needs in a recording, or may come only from a node itself.
NOT_RECORDED = re.compile(
    r"/rosout.*|/imaging/description|/imaging_progress|/._axis/endstop|/service_status|"
    r"/._axis/axis/(goal|cancel|feedback)"
)
AREA = {"x_points": 7, "x_stop_mm": 40.0, "y_points": 6, "y_stop_mm": 35.0}
TRACES = 84
PARENTS = {
    frames.BASE_LINK: frames.MAP,
    frames.Y_CARRIAGE_LINK: frames.BASE_LINK,
    frames.X_CARRIAGE_LINK: frames.Y_CARRIAGE_LINK,
    frames.ANTENNA_LINK: frames.X_CARRIAGE_LINK,
    frames.HEIGHT_SENSOR_LINK: frames.X_CARRIAGE_LINK,
}
PLACED = {
    "/measured_height": frames.HEIGHT_SENSOR_LINK,
    "/trace": frames.ANTENNA_LINK,
    **dict.fromkeys(
        (
            *("/control_current_coordinate", "/control_target_coordinate", "/b_scan"),
            *("/x_axis/current_coord", "/survey_area", "/stops"),
        ),
        frames.BASE_LINK,
    ),
}
NUMBERS = ("frequency_hz", "s21_real", "s21_imag")
SCALARS = ("index", "x_coord_mm", "y_coord_mm", "z_coord_deg", "antennae_height_m")
CLOCK_LIMIT_S = 1.0


class Heard:
    """Every message of some topics, and the header of every message that has one."""

    def __init__(self):
        self.headers = defaultdict(list)
        self.messages = defaultdict(list)
        self._changed = threading.Condition()
        # Made with its first message.
        self.subscribers = {"/b_scan": self._subscriber("/b_scan", Image)}

    def listen(self):
        """Subscribe to the topics that are new."""
        for topic, kind in rospy.get_published_topics():
            message_class = roslib.message.get_message_class(kind)
            stamped = "header" in message_class.__slots__
            if topic not in self.subscribers and (
                stamped or message_class in (TFMessage, String, Log)
            ):
                self.subscribers[topic] = self._subscriber(topic, message_class)

    def _subscriber(self, topic, kind):
        return rospy.Subscriber(topic, kind, self._note, callback_args=topic)

    def _note(self, message, topic):
        parts = message.transforms if isinstance(message, TFMessage) else [message]
        now = rospy.Time.now()
        with self._changed:
            self.messages[topic].append(message)
            self.headers[topic] += [(one.header, now) for one in parts if hasattr(one, "header")]
            self._changed.notify_all()

    def wait(self, topic, condition=len):
        """Wait until a condition on the messages of a topic holds; return them."""
        with self._changed:
            found = self.messages[topic]
            assert self._changed.wait_for(lambda: condition(found), LIMIT_S), topic
            return list(found)


class WholeSurveyTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        # The master says that the time is simulated, which no robot may believe.
        rospy.init_node("whole_survey_rostest", disable_rostime=True)
        cls.begun = rospy.Time.now() - rospy.Duration(LIMIT_S)
        cls.client = SurveyClient()
        cls.own_topic = rospy.Publisher(OWN_TOPIC, String, queue_size=1, latch=True)
        cls.own_topic.publish("moist")
        cls.heard = Heard()
        cls.heard.listen()
        for name, kind in (
            ("add_fact", AddFact),
            ("export_survey", ExportSurvey),
            ("focus_survey", FocusSurvey),
        ):
            setattr(cls, name.split("_")[0], staticmethod(rospy.ServiceProxy(name, kind)))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def description(self):
        return read_description(self.folder)

    def test_1_a_survey_is_imaged_annotated_and_marked_while_it_runs(self):
        coarse, first, second = (str(uuid.uuid4()) for _one in range(3))
        at_start = Annotation(operator="Lucía Peña", site="El Carmen", notes="dry\nsoil")
        survey_id = self.client.begin(at_start, refines=coarse, **AREA)
        self.client.wait_for_visited(TRACES // 2)
        self.assertTrue(self.client.pause().success)
        self.client.wait_for_status(ControlStatus.PAUSED)
        type(self).folder = self.client.folder(survey_id)
        later = annotation.Annotation("Lucía Peña", position=Wgs84Position(4.6, 0.0))
        for kind, values in (
            ("annotation", later.values()),
            ("marker", Marker(first, 12.5, 15.0, 80.0, "metal", "Lucía Peña").request()),
            ("marker", Marker(second, 12.5, 15.0, None, "metal", "Lucía Peña").request()),
        ):
            answer = self.add("", kind, json.dumps(values))
            self.assertEqual((answer.success, answer.survey_id), (True, survey_id), answer)
        self.assertEqual(len(json.loads(answer.markers_json)), 2)
        answer = self.focus(request_id="during", survey=survey_id, permittivity=5.0)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.traces, len(json_traces(self.folder)))
        self.assertTrue(json.loads(answer.candidates_json)["simulated"])
        shape = len(answer.depth_mm), len(answer.y_mm), len(answer.x_mm)
        empty = np.isnan(np.frombuffer(answer.levels_db, "<f4").reshape(shape)).all(axis=0)
        # Lines are measured in ascending order of Y.
        self.assertTrue(not empty[0].any() and empty[-1].all())
        self.client.forget()
        self.client.go_on(survey_id)
        self.assertTrue(self.client.finished().simulated)
        removal = json.dumps({"marker_id": first, "author": ""})
        self.assertTrue(self.add(self.folder.name, "marker_removed", removal).success)
        description = self.description()
        self.assertEqual((description["refines"], description["permittivity"]), (coarse, 4.0))
        self.assertEqual(description["annotation"]["position"]["latitude_deg"], 4.6)
        self.assertEqual([one.marker_id for one in present_markers(description)], [second])
        page = self.export("page", survey_id, ["report-html"], 5.0, "en", "")
        self.assertIn("SIMULATED_report.html", page.files[0])
        self.assertIn(str(NO_CLEARANCE), page.content.decode())

    def test_2_every_trace_is_the_same_in_each_form_and_where_it_was_planned(self):
        stored = json_traces(self.folder)
        planned = {
            (10.0 + 5.0 * column, 10.0 + 5.0 * row, z)
            for column in range(7)
            for row in range(6)
            for z in (0.0, 90.0)
        }
        visited = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
        self.assertEqual((visited, len(stored)), (planned, TRACES))
        for one in stored:
            # A trap of earlier software: the imaginary part was a copy of the real one.
            self.assertNotEqual(one["s21_real"], one["s21_imag"])
            self.assertAlmostEqual(one["antennae_height_m"], 0.20, delta=0.01)
        recorded = self.check_recordings(self.folder, stored)
        published = {topic for topic, _kind in rospy.get_published_topics()}
        # Playing a recording beside a robot must not move it.
        self.assertEqual({one for one in recorded if NOT_RECORDED.fullmatch(one)}, set())
        missing = {one for one in published - recorded if not NOT_RECORDED.fullmatch(one)}
        self.assertEqual(missing, set())
        self.assertIn(OWN_TOPIC, recorded)
        self.assertLessEqual({f"/{axis}_axis/axis/goal_recorded" for axis in "xyz"}, recorded)
        found = verify_survey(self.folder)
        self.assertEqual((found.status, found.faults, found.stored), (0, [], TRACES))
        self.assertIn("Anritsu,MS2026C/2,SIMULATED", json.dumps(self.description()))
        self.client.wait(lambda: self.client.progress[-1].remaining_points == 0)

    def check_recordings(self, folder, stored):
        """Compare the traces of both recordings; return the topics of the bag."""
        wait_for_bag(folder)
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            in_bag = [message for _topic, message, _time in bag.read_messages(["/trace"])]
            topics = set(bag.get_type_and_topic_info().topics)
        in_mcap = read_ros1_messages(str(folder / "survey.mcap"), topics=["/trace"])
        for traces in (in_bag, [one.ros_msg for one in in_mcap]):
            self.assertEqual(len(traces), len(stored))
            for one, message in zip(stored, sorted(traces, key=lambda trace: trace.index)):
                for name in (*SCALARS, "survey_id", "sample_id", "format", "quality"):
                    self.assertEqual(one[name], getattr(message, name))
                for name in NUMBERS:
                    self.assertEqual(bits(one[name]), bits(list(getattr(message, name))))
        return topics

    def test_3_tools_find_frames_joints_pictures_and_stamps(self):
        self.heard.listen()
        self.heard.wait("/stops", lambda found: found and len(found[-1].points) == 42)
        pictures = self.heard.wait("/b_scan", lambda found: len(found) >= 6)
        self.assertEqual(len(pictures), 6)  # one for each line
        for one in pictures:
            self.assertEqual((one.encoding, one.step), ("mono8", one.width))
            picture = np.frombuffer(one.data, np.uint8).reshape(one.height, one.width)
            self.assertGreater(len(np.unique(picture)), 10)
        (outline,) = self.heard.wait("/survey_area")
        self.assertEqual((outline.points[0].x, outline.points[2].y), (0.01, 0.035))
        self.assertIn("<robot", self.heard.wait("/robot_description")[0].data)
        moving, fixed = self.heard.wait("/tf"), self.heard.wait("/tf_static")
        found = moving[-1].transforms + fixed[-1].transforms
        self.assertEqual({one.child_frame_id: one.header.frame_id for one in found}, PARENTS)
        self.check_headers()

    def check_headers(self):
        for topic, headers in list(self.heard.headers.items()):
            for header, received in list(headers):
                # The time is real, whatever the master says.
                self.assertGreater(header.stamp, self.begun, topic)
                self.assertLess(header.stamp, received + rospy.Duration(CLOCK_LIMIT_S), topic)
                self.assertIn(header.frame_id, {"", frames.MAP, *PARENTS}, topic)
        for topic, frame in PLACED.items():
            self.assertEqual({one.frame_id for one, _at in self.heard.headers[topic]}, {frame})

    def test_4_nobody_warned_of_anything(self):
        alarming = [
            f"{one.name}: {one.msg}"
            for one in self.heard.messages["/rosout"]
            if one.level >= Log.WARN
            and "refused" not in one.msg
            # A client that ended while it connected, as rospy says.
            and "before handshake header received" not in one.msg
        ]
        self.assertEqual(alarming, [])


if __name__ == "__main__":
    rostest.rosrun("gpr20", "whole_survey", WholeSurveyTest)
