#!/usr/bin/env python3
"""What tools for ROS expect: headers, tf, joint_states, images, markers, shown parameters."""

import math
import os
import shutil
import signal
import threading
import time
import unittest

import numpy as np
import rosbag
import roslib.message
import rospy
import rostest
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import String
from survey_client import LIMIT_S, SurveyClient, described, node_pid
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from gpr20_msgs.msg import ControlStatus, Coordinates
from gpr20_survey import frames

PARENTS = {
    frames.BASE_LINK: frames.MAP,
    frames.Y_CARRIAGE_LINK: frames.BASE_LINK,
    frames.X_CARRIAGE_LINK: frames.Y_CARRIAGE_LINK,
    frames.ANTENNA_LINK: frames.X_CARRIAGE_LINK,
    frames.HEIGHT_SENSOR_LINK: frames.X_CARRIAGE_LINK,
}
PLACED = {
    "measured_height": frames.HEIGHT_SENSOR_LINK,
    "trace": frames.ANTENNA_LINK,
    "control_current_coordinate": frames.BASE_LINK,
    "control_target_coordinate": frames.BASE_LINK,
    "x_axis/current_coord": frames.BASE_LINK,
    "b_scan": frames.BASE_LINK,
    "survey_area": frames.BASE_LINK,
    "stops": frames.BASE_LINK,
}
RECORDED = (
    "tf",
    "tf_static",
    "joint_states",
    "robot_description",
    "b_scan",
    "survey_area",
    "stops",
)
CLOCK_LIMIT_S = 1.0
FRESH_S = 2.0


class Graph:
    """Receives every message of every topic that has a header, or transforms."""

    def __init__(self):
        self.started = rospy.Time.now() - rospy.Duration(LIMIT_S)
        self.headers = {}
        self._lock = threading.Lock()
        self._subscribers = {}

    def listen(self):
        """Subscribe to the topics that are new."""
        for topic, kind in rospy.get_published_topics():
            message_class = roslib.message.get_message_class(kind)
            if topic in self._subscribers or message_class is None:
                continue
            if "header" in message_class.__slots__ or message_class is TFMessage:
                self._subscribers[topic] = rospy.Subscriber(
                    topic, message_class, self._note, callback_args=topic
                )

    def _note(self, message, topic):
        stamped = message.transforms if isinstance(message, TFMessage) else [message]
        with self._lock:
            found = self.headers.setdefault(topic, [])
            found += [(one.header.stamp, one.header.frame_id, rospy.Time.now()) for one in stamped]

    def received(self):
        """Return the headers of each topic with the time of their reception."""
        with self._lock:
            return {topic: list(found) for topic, found in self.headers.items()}


class Last:
    """The last message of a topic, and how many came."""

    def __init__(self, topic, kind):
        self._changed = threading.Condition()
        self.messages = []
        self._subscriber = rospy.Subscriber(topic, kind, self._note)

    def _note(self, message):
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def wait(self, condition):
        """Wait until a condition on the messages holds; return them."""
        with self._changed:
            assert self._changed.wait_for(lambda: condition(self.messages), LIMIT_S)
            return list(self.messages)


class StandardMessagesTest(unittest.TestCase):
    def test_tools_find_what_they_expect(self):
        rospy.init_node("standard_messages_rostest", disable_rostime=True)
        graph = Graph()
        client = SurveyClient()
        self.addCleanup(shutil.rmtree, client.data)
        moving, fixed = Last("tf", TFMessage), Last("tf_static", TFMessage)
        joints, pictures = Last("joint_states", JointState), Last("b_scan", Image)
        positions, stops = Last("control_current_coordinate", Coordinates), Last("stops", Marker)
        area, robot = Last("survey_area", Marker), Last("robot_description", String)
        graph.listen()

        survey_id, status = client.run_to_end(x_points=4)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        graph.listen()
        pictures.wait(lambda found: len(found) >= 3)
        stops.wait(lambda found: found and len(found[-1].points) == 12)
        (outline,) = area.wait(len)
        self.assertEqual((outline.points[0].x, outline.points[2].y), (0.01, 0.02))
        self.assertIn("<robot", robot.wait(len)[0].data)

        self._check_frames(moving.wait(len), fixed.wait(len))
        self._check_joints(joints, positions)
        self._check_pictures(pictures.messages)
        self._check_headers(graph)
        self._check_recording(client.folder(survey_id))
        self._check_shown_parameters()
        # Of the node that was started again, too.
        self._check_headers(graph)

    def _check_frames(self, moving, fixed):
        found = moving[-1].transforms + fixed[-1].transforms
        self.assertEqual({one.child_frame_id: one.header.frame_id for one in found}, PARENTS)
        begun_s = time.monotonic()
        fresh = rospy.wait_for_message("tf", TFMessage, FRESH_S)
        self.assertLess(time.monotonic() - begun_s, FRESH_S)
        age_s = (rospy.Time.now() - fresh.transforms[0].header.stamp).to_sec()
        self.assertLess(age_s, FRESH_S)
        stamps = [one.transforms[0].header.stamp for one in moving]
        self.assertEqual(stamps, sorted(stamps))
        # 10 a second at most, and some that are late.
        self.assertLess(len(stamps), 11 * (stamps[-1] - stamps[0]).to_sec() + 5)

    def _check_joints(self, joints, positions):
        published = {one.header.stamp: one for one in positions.messages}
        states = [one for one in joints.messages if one.header.stamp in published]
        self.assertGreater(len(states), 5)
        for state in states:
            place = published[state.header.stamp]
            self.assertEqual(state.name, ["y_axis_joint", "x_axis_joint", "z_axis_joint"])
            expected = (place.y_mm / 1000.0, place.x_mm / 1000.0, math.radians(place.z_deg))
            np.testing.assert_allclose(state.position, expected, atol=1e-12)

    def _check_pictures(self, pictures):
        self.assertEqual(len(pictures), 3)  # one for each line
        for one in pictures:
            self.assertEqual((one.encoding, one.step), ("mono8", one.width))
            picture = np.frombuffer(one.data, np.uint8).reshape(one.height, one.width)
            self.assertGreater(len(np.unique(picture)), 10)

    def _check_headers(self, graph):
        now = rospy.Time.now()
        received = graph.received()
        for topic, headers in received.items():
            for stamp, frame, received_at in headers:
                self.assertGreater(stamp, graph.started, topic)
                limit = received_at + rospy.Duration(CLOCK_LIMIT_S)
                self.assertLess(stamp, min(limit, now + rospy.Duration(CLOCK_LIMIT_S)), topic)
                self.assertIn(frame, {"", frames.MAP, *PARENTS}, topic)
        for name, frame in PLACED.items():
            topic = rospy.resolve_name(name)
            self.assertEqual({one for _stamp, one, _at in received[topic]}, {frame}, topic)
        self.assertIn("/diagnostics", received)

    def _check_recording(self, folder):
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            topics = bag.get_type_and_topic_info().topics
            for topic, message, _time in bag.read_messages():
                if hasattr(message, "header"):
                    self.assertTrue(message.header.stamp, topic)
        for name in RECORDED:
            self.assertIn(rospy.resolve_name(name), topics)
        self.assertEqual(topics[rospy.resolve_name("b_scan")].message_count, 3)

    def _check_shown_parameters(self):
        self.assertEqual(rospy.get_param("x_axis/axis_driver/max_step"), 0.005)
        self.assertEqual(rospy.get_param("main_control/settle_s"), 0.5)
        self.assertEqual(rospy.get_param("vna_processing/readable_by"), "group")
        # They are shown only: a node that restarts has what it was launched with, and shows it.
        rospy.set_param("height_sensor/samples", 9)
        os.kill(node_pid(rospy.resolve_name("height_sensor")), signal.SIGKILL)
        deadline_s = time.monotonic() + LIMIT_S
        while rospy.get_param("height_sensor/samples") != 5:
            self.assertLess(time.monotonic(), deadline_s)
            time.sleep(0.05)
        self.assertEqual(described("height_sensor")["samples"], 5)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "standard_messages", StandardMessagesTest)
