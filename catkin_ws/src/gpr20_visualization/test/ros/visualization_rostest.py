#!/usr/bin/env python3
"""The node beside a player of recordings, without tf (old) and with it (new)."""

import threading
import unittest

import rosgraph
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from gpr20_msgs.msg import Coordinates
from gpr20_survey.frames import BASE_LINK, MAP

LIMIT_S = 60.0
# Of a recording that was made long ago.
STAMP = rospy.Time(1_600_000_000, 250_000_000)
OWN = ("tf", "tf_static", "joint_states", "robot_description", "b_scan", "survey_area", "stops")


class VisualizationTest(unittest.TestCase):
    """Runs once in each namespace; this node is the player."""

    def setUp(self):
        self.changed = threading.Condition()
        self.reports = []
        self.transforms = []
        self.positions = rospy.Publisher("control_current_coordinate", Coordinates, queue_size=10)
        self.plays_tf = rospy.get_namespace() == "/new/"
        self.kept = [
            rospy.Subscriber("/diagnostics", DiagnosticArray, self.report),
            rospy.Subscriber("tf", TFMessage, self.transform),
        ]
        if self.plays_tf:
            self.kept.append(rospy.Publisher("joint_states", JointState, queue_size=10))

    def report(self, message):
        with self.changed:
            name = rospy.resolve_name("visualization").lstrip("/")
            self.reports += [one for one in message.status if one.name.startswith(name)]
            self.changed.notify_all()

    def transform(self, message):
        with self.changed:
            self.transforms.append(message)
            self.changed.notify_all()

    def wait(self, condition):
        with self.changed:
            self.assertTrue(self.changed.wait_for(condition, LIMIT_S))

    def play(self, condition):
        """Publish positions until a condition holds."""
        deadline = rospy.Time.now() + rospy.Duration(LIMIT_S)
        message = Coordinates(x_mm=100.0, y_mm=200.0, z_deg=90.0)
        message.header.stamp = STAMP
        while not condition():
            self.assertLess(rospy.Time.now(), deadline)
            message.header.stamp += rospy.Duration(0, 100_000_000)
            self.positions.publish(message)
            rospy.sleep(0.05)

    def own_topics(self):
        """Return the topics that the node publishes, of those a recording may hold."""
        published, _subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
        node = rospy.resolve_name("visualization")
        names = {topic: name for name in OWN for topic in (rospy.resolve_name(name),)}
        return {names[topic] for topic, nodes in published if node in nodes and topic in names}

    def test_it_completes_old_recordings_and_leaves_new_ones_alone(self):
        if self.plays_tf:
            # Between two reports there is time for what it would publish.
            self.play(lambda: len(self.reports) > 3)
            self.assertEqual(self.own_topics(), set())
            return
        # Alone it has advertised nothing: a replay refuses topics that another node publishes.
        self.wait(lambda: self.reports)
        self.assertEqual(self.own_topics(), set())
        self.play(lambda: self.transforms)
        found = self.transforms[0].transforms
        self.assertEqual([round(one.transform.translation.y, 9) for one in found], [0.2, 0.0, 0.0])
        # Stamps are those of the recording.
        self.assertLess(found[0].header.stamp - STAMP, rospy.Duration(LIMIT_S))
        fixed = rospy.wait_for_message("tf_static", TFMessage, LIMIT_S).transforms
        self.assertEqual((fixed[0].header.frame_id, fixed[0].child_frame_id), (MAP, BASE_LINK))
        urdf = rospy.wait_for_message("robot_description", String, LIMIT_S).data
        self.assertIn('<robot name="gpr20">', urdf)


if __name__ == "__main__":
    rospy.init_node("player", anonymous=True)
    rostest.rosrun("gpr20_visualization", "visualization", VisualizationTest)
