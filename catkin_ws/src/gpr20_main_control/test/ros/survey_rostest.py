#!/usr/bin/env python3
"""A survey that meets faults: what the operator reads, and that it goes on afterwards."""

import math
import os
import shutil
import signal
import sys
import time
import unittest
from xmlrpc.client import ServerProxy

import rosgraph
import rosnode
import rospkg
import rospy
import rostest

from gpr20_msgs.msg import ControlStatus, CurrentCoordinate
from gpr20_simulator.high.world_path import world_path
from gpr20_simulator.low.world import AxisName, open_world
from gpr20_simulator.srv import SetFault

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import LIMIT_S, SurveyClient, json_traces


class SurveyFaultsTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("survey_rostest")
        cls.client = SurveyClient()
        cls.world = open_world(world_path("/"), {})
        rospy.wait_for_service("simulator/set_fault", LIMIT_S)
        cls._set_fault = rospy.ServiceProxy("simulator/set_fault", SetFault)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def fault(self, device, name):
        answer = self._set_fault(device, name, 0)
        self.assertTrue(answer.success, answer.message)

    def wait_for_visited(self, points):
        self.client.wait(
            lambda: self.client.progress and self.client.progress[-1].visited_points >= points
        )

    def finish(self, survey_id):
        """Resume the paused survey; it must end complete, every point once."""
        self.client.go_on(survey_id)
        status = self.client.wait_for_status(
            ControlStatus.FINISHED, ControlStatus.FAILED, ControlStatus.PAUSED
        )
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        stored = json_traces(self.client.folder(survey_id))
        self.assertEqual([one["index"] for one in stored], list(range(18)))
        places = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
        self.assertEqual(len(places), 18)
        return stored

    def test_1_a_stop_during_homing_ends_it(self):
        self.client.begin()
        self.client.wait_for_status(ControlStatus.HOMING)
        rospy.wait_for_message("x_axis/current_coord", CurrentCoordinate, LIMIT_S)
        self.assertTrue(self.client.stop().success)
        requested_ns = time.monotonic_ns()
        status = self.client.wait_for_status(ControlStatus.STOPPED)
        self.assertIn("0 of 18 traces", status.message)
        for axis in (AxisName.X, AxisName.Y):
            self.assertNotEqual(self.world.steps(axis), 0)
            self.assertLess(self.world.last_pulse_ns(axis) - requested_ns, 1_000_000_000)
        reading = rospy.wait_for_message("x_axis/current_coord", CurrentCoordinate, LIMIT_S)
        self.assertFalse(reading.homed or reading.moving)

    def test_2_numbers_that_are_none_pause_the_survey_and_are_never_stored(self):
        survey_id = self.client.begin()
        self.wait_for_visited(3)
        self.fault("vna", "NAN")
        status = self.client.wait_for_status(ControlStatus.PAUSED)
        self.assertIn("get_data", status.message)
        self.assertIn("resume", status.message)
        self.fault("vna", "NONE")
        for one in self.finish(survey_id):
            self.assertTrue(all(map(math.isfinite, one["s21_real"] + one["s21_imag"])))

    def test_3_an_endstop_that_closes_in_a_move_pauses_the_survey_until_the_axis_is_homed(self):
        survey_id = self.client.begin()
        self.wait_for_visited(7)
        # The second row leads towards the endstop of x.
        self.fault("endstop_x", "STUCK_CLOSED")
        status = self.client.wait_for_status(ControlStatus.PAUSED)
        self.assertIn("x axis did not reach", status.message)
        self.assertIn("endstop was pressed", status.message)
        self.client.go_on(survey_id)
        status = self.client.wait_for_status(ControlStatus.PAUSED)
        self.assertIn("homing the x axis failed", status.message)
        self.assertIn("stuck closed", status.message)
        self.fault("endstop_x", "NONE")
        self.finish(survey_id)
        self.assertEqual(self.world.steps(AxisName.X), 2000)

    def test_4_a_height_sensor_out_of_range_pauses_the_survey(self):
        survey_id = self.client.begin()
        self.wait_for_visited(2)
        self.fault("adc", "OUT_OF_RANGE")
        status = self.client.wait_for_status(ControlStatus.PAUSED)
        self.assertIn("the antenna height could not be measured", status.message)
        self.fault("adc", "NONE")
        self.finish(survey_id)

    def test_5_an_axis_whose_node_dies_pauses_the_survey_which_can_still_be_stopped(self):
        survey_id = self.client.begin(x_stop_mm=600.0)
        self.wait_for_visited(2)
        os.kill(rosnode_pid("/z_axis/axis_driver"), signal.SIGKILL)
        status = self.client.wait_for_status(ControlStatus.PAUSED)
        self.assertIn("z_axis", status.message.replace(" ", "_"))
        self.assertTrue(self.client.stop().success)
        status = self.client.wait_for_status(ControlStatus.STOPPED)
        stored = json_traces(self.client.folder(survey_id))
        self.assertIn(f"{len(stored)} of 18 traces", status.message)
        self.assertGreaterEqual(len(stored), 2)


def rosnode_pid(name):
    """Return the process of a node."""
    server = rosnode.get_api_uri(rosgraph.Master(rospy.get_name()), name)
    _code, _message, pid = ServerProxy(server).getPid(rospy.get_name())
    return pid


if __name__ == "__main__":
    rostest.rosrun("gpr20_main_control", "survey_faults", SurveyFaultsTest)
