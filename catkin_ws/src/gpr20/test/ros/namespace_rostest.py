#!/usr/bin/env python3
"""Two robots in their namespaces survey at once, and neither notices the other."""

import shutil
import unittest

import rosbag
import rospy
import rostest
from survey_client import SurveyClient, bits, json_traces

from gpr20_msgs.msg import ControlStatus

ROBOTS = ("/robot1", "/robot2")
# Another part of the ground: the traces of the robots differ.
AREAS = {
    "/robot1": {"x_points": 5, "y_points": 5},
    "/robot2": {
        **{"x_start_mm": 30.0, "x_stop_mm": 40.0, "x_points": 5},
        **{"y_start_mm": 30.0, "y_stop_mm": 40.0, "y_points": 5},
    },
}
TRACES = 50


class NamespaceTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("namespace_rostest")
        cls.clients = {robot: SurveyClient(robot) for robot in ROBOTS}

    @classmethod
    def tearDownClass(cls):
        for client in cls.clients.values():
            shutil.rmtree(client.data)

    def assert_finishes(self, robot):
        status = self.clients[robot].wait_for_status(ControlStatus.FINISHED, ControlStatus.FAILED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)

    def test_two_robots_survey_at_once_and_each_records_its_own_topics(self):
        ids = {robot: client.begin(**AREAS[robot]) for robot, client in self.clients.items()}
        for robot, client in self.clients.items():
            client.wait_for_visited(1)
            others = [one for name, one in self.clients.items() if name != robot]
            self.assertNotIn(ControlStatus.FINISHED, [one.statuses[-1].code for one in others])
        for robot, survey_id in ids.items():
            self.assert_finishes(robot)
            self.assert_own_survey(robot, survey_id)
        measured = [
            {bits(trace["s21_real"]) for trace in self.traces(robot, survey_id)}
            for robot, survey_id in ids.items()
        ]
        self.assertEqual(set.intersection(*measured), set())

    def test_stop_and_a_fault_of_one_robot_leave_the_other_alone(self):
        first, second = (self.clients[robot] for robot in ROBOTS)
        first.begin(x_points=20, y_points=20)
        survey_id = second.begin(**AREAS["/robot2"])
        first.wait_for_visited(1)
        self.addCleanup(first.set_fault, device="adc", fault="NONE", count=0)
        answer = first.set_fault(device="adc", fault="STUCK", count=0)
        self.assertTrue(answer.success, answer.message)
        first.wait_for_status(ControlStatus.PAUSED)
        self.assertTrue(first.stop().success)
        first.wait_for_status(ControlStatus.STOPPED)
        self.assert_finishes("/robot2")
        self.assertNotIn(ControlStatus.PAUSED, [one.code for one in second.statuses])
        self.assert_own_survey("/robot2", survey_id)

    def traces(self, robot, survey_id):
        return json_traces(self.clients[robot].folder(survey_id))

    def assert_own_survey(self, robot, survey_id):
        traces = self.traces(robot, survey_id)
        self.assertEqual(len(traces), TRACES)
        self.assertEqual({trace["survey_id"] for trace in traces}, {survey_id})
        folder = self.clients[robot].folder(survey_id)
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            topics = bag.get_type_and_topic_info().topics
        self.assertEqual(topics[f"{robot}/trace"].message_count, TRACES)
        others = [topic for topic in topics if not topic.startswith((f"{robot}/", "/diagnostics"))]
        self.assertEqual(others, [])


if __name__ == "__main__":
    rostest.rosrun("gpr20", "namespace", NamespaceTest)
