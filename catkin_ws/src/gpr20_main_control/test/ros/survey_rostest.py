#!/usr/bin/env python3
"""A survey that is stopped while the axes are homed."""

import json
import os
import shutil
import sys
import time
import unittest

import rospkg
import rospy
import rostest

from gpr20_common.sent_message import message_from, received_message
from gpr20_msgs.msg import ControlStatus, CurrentCoordinate, SurveyCoverage
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes.axis_id import AxisId

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import LIMIT_S, SurveyClient

# On a computer that stalls; the homing alone would take longer.
STOP_LIMIT_NS = 3_000_000_000


class SurveyFaultsTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("survey_rostest")
        cls.client = SurveyClient()
        cls.world = open_shared_state(shared_state_path("/"))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def test_1_a_stop_during_homing_ends_it(self):
        self.client.begin()
        self.client.wait_for_status(ControlStatus.HOMING)
        rospy.wait_for_message("x_axis/current_coord", CurrentCoordinate, LIMIT_S)
        answer = self.client.stop()
        requested_ns = time.monotonic_ns()
        self.assertTrue(answer.success)
        self.assertEqual(message_from(answer).sentence(), answer.message)
        self.assertNotEqual(message_from(answer).template, "{text}")
        status = self.client.wait_for_status(ControlStatus.STOPPED)
        self.assertIn("0 of 18 traces", status.message)
        _stopped, stored = message_from(status).values["sentences"]
        self.assertEqual((stored.values["stored"], stored.values["total"]), (0, 18))
        self.check_verdict(status.survey_id)
        for axis in (AxisId.X, AxisId.Y):
            self.assertNotEqual(self.world.steps(axis), 0)
            self.assertLess(self.world.last_pulse_ns(axis) - requested_ns, STOP_LIMIT_NS)
        reading = rospy.wait_for_message("x_axis/current_coord", CurrentCoordinate, LIMIT_S)
        self.assertFalse(reading.homed or reading.moving)

    def check_verdict(self, survey_id):
        """The verdict must be the same on the graph and in survey.json."""
        coverage = rospy.wait_for_message("survey_coverage", SurveyCoverage, LIMIT_S)
        verdict = received_message("", coverage.verdict_json)
        self.assertEqual((verdict.values["stored"], verdict.values["planned"]), (0, 18))
        description = json.loads((self.client.folder(survey_id) / "survey.json").read_text())
        report = description["report"]
        self.assertEqual(report["verdict"], coverage.verdict)
        stored = received_message("", json.dumps(report["verdict_message"]))
        self.assertEqual(stored, verdict)


if __name__ == "__main__":
    rostest.rosrun("gpr20_main_control", "survey_faults", SurveyFaultsTest)
