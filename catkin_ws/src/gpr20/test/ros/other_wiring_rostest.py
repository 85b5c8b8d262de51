#!/usr/bin/env python3
"""A robot that is wired in another way than the built one homes and surveys correctly."""

import shutil
import unittest

import rospy
import rostest
from survey_client import SurveyClient, json_traces

from gpr20_msgs.msg import ControlStatus

TRACES = 18


class OtherWiringTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("other_wiring_rostest")
        cls.client = SurveyClient()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def test_every_trace_is_measured_where_it_says(self):
        survey_id, status = self.client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        traces = json_traces(self.client.folder(survey_id))
        self.assertEqual(len(traces), TRACES)
        for trace in traces:
            # What the simulated analyzer sees is the true position, in single precision.
            place = trace["x_coord_mm"] + trace["y_coord_mm"] / 1000.0
            self.assertAlmostEqual(trace["s21_imag"][0], place, 3)
            rotation = (trace["z_coord_deg"] + 90.0) / 200.0
            self.assertAlmostEqual(trace["s21_real"][0] % 1.0, rotation, 3)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "other_wiring", OtherWiringTest)
