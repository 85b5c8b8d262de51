#!/usr/bin/env python3
"""A robot inside a namespace measures by itself, beside another one."""

import shutil
import unittest

import rosbag
import rospy
import rostest
from survey_client import SurveyClient, json_traces

from gpr20_msgs.msg import ControlStatus


class NamespaceTest(unittest.TestCase):
    """Runs once in the namespace of each robot."""

    def test_a_robot_in_a_namespace_records_its_own_topics(self):
        rospy.init_node("namespace_rostest")
        robot = rospy.get_namespace().rstrip("/")
        self.assertIn(robot, ("/robot1", "/robot2"))
        client = SurveyClient()
        self.addCleanup(shutil.rmtree, client.data)
        survey_id, status = client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        folder = client.folder(survey_id)
        self.assertEqual(len(json_traces(folder)), 18)
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            topics = bag.get_type_and_topic_info().topics
        self.assertEqual(topics[f"{robot}/trace"].message_count, 18)
        others = [topic for topic in topics if not topic.startswith((f"{robot}/", "/diagnostics"))]
        self.assertEqual(others, [])


if __name__ == "__main__":
    rostest.rosrun("gpr20", "namespace", NamespaceTest)
