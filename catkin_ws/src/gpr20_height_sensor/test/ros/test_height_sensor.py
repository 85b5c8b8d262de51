#!/usr/bin/env python3
"""The service and the topic of the height sensor over a simulated ground."""

from __future__ import annotations

import math
import statistics
import time
import unittest

import rospy
import rostest
from sensor_msgs.msg import Range

from gpr20_common.sent_message import message_from
from gpr20_height_sensor import faults
from gpr20_height_sensor.mid.height_parameters import HeightParameters
from gpr20_msgs.srv import GetHeight
from gpr20_simulator.srv import SetFault

# The height of the antennas in the scene of this test, over its level ground.
SCENE_HEIGHT_M = 0.20
FIND_LIMIT_S = 60.0
PARAMETERS = HeightParameters()
# Two periods until a reading is fresh, then one more for each but the first.
MEASURING_S = (2 + PARAMETERS.samples - 1) * PARAMETERS.update_period_s


class HeightSensorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_height_sensor")
        rospy.wait_for_service("get_height", FIND_LIMIT_S)
        rospy.wait_for_service("simulator/set_fault", FIND_LIMIT_S)
        cls.get_height = rospy.ServiceProxy("get_height", GetHeight)
        cls.set_fault = rospy.ServiceProxy("simulator/set_fault", SetFault)

    def setUp(self):
        self.fault("none")

    def fault(self, name):
        answer = type(self).set_fault("adc", name, 0)
        self.assertTrue(answer.success, answer.message)

    def wait_for_range(self, condition, limit_s=30.0):
        deadline_s = time.monotonic() + limit_s
        while time.monotonic() < deadline_s:
            message = rospy.wait_for_message("measured_height", Range, limit_s)
            if condition(message.range):
                return message
        return self.fail("no such height was published in time")

    def test_the_height_is_that_of_the_scene(self):
        requested = rospy.Time.from_sec(time.time())
        answer = type(self).get_height()
        self.assertTrue(answer.success, answer.message)
        self.assertAlmostEqual(answer.height_m, SCENE_HEIGHT_M, delta=0.005)
        self.assertEqual(answer.samples, PARAMETERS.samples)
        self.assertLess(answer.spread_m, 0.005)
        self.assertGreaterEqual(answer.measured, requested + rospy.Duration(2 * 0.048))

    def test_the_topic_never_delays_the_service(self):
        took_s = []
        for _ in range(9):
            begun_s = time.monotonic()
            self.assertTrue(type(self).get_height().success)
            took_s.append(time.monotonic() - begun_s)
        # A measurement that waited for the topic's would take up to twice as long. The median, as
        # the computer may stall in some of them.
        self.assertLess(statistics.median(took_s), 1.5 * MEASURING_S)

    def test_the_topic_shows_the_height_in_metres_with_its_limits(self):
        message = self.wait_for_range(math.isfinite)
        self.assertAlmostEqual(message.range, SCENE_HEIGHT_M, delta=0.005)
        self.assertEqual(message.radiation_type, Range.INFRARED)
        self.assertEqual(message.header.frame_id, "height_sensor_link")
        self.assertAlmostEqual(message.min_range, 0.10, places=6)
        self.assertAlmostEqual(message.max_range, 0.80, places=6)
        self.assertGreater(message.field_of_view, 0.0)
        self.assertGreater(message.header.stamp.to_sec(), 1e9)

    def test_a_stuck_converter_is_told_and_no_height_is_published(self):
        self.fault("stuck")
        answer = type(self).get_height()
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault_code, faults.SENSOR_OFF.code)
        self.assertTrue(math.isnan(answer.height_m))
        self.wait_for_range(math.isnan)
        self.fault("none")
        self.wait_for_range(math.isfinite)
        self.assertTrue(type(self).get_height().success)

    def test_a_sensor_out_of_its_range_is_told(self):
        self.fault("out_of_range")
        answer = type(self).get_height()
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault_code, faults.OUT_OF_RANGE.code)
        message = message_from(answer)
        self.assertEqual(message.fault_code, answer.fault_code)
        self.assertEqual(message.values["nearest_m"], 0.1)


if __name__ == "__main__":
    rostest.rosrun("gpr20_height_sensor", "test_height_sensor", HeightSensorTest)
