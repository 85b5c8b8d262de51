#!/usr/bin/env python3
"""Nodes that die or hang: control_status names them soon, and the survey loses nothing."""

import os
import shutil
import signal
import sys
import time
import unittest

import rospkg
import rospy
import rostest

from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import ControlStatus

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import SurveyClient, json_traces, node_pid

# Two seconds, and what a computer may stall; a survey waits far longer for the node.
NOTICE_LIMIT_S = 15.0
TRACES = 18
ENDED = (ControlStatus.FINISHED, ControlStatus.PAUSED, ControlStatus.FAILED)


def missing_nodes(status):
    """Return the nodes that do not answer, by the warning of a status."""
    warning = message_from(status).values.get("warning")
    return () if warning is None else warning.all_details


class NodeDeathsTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("node_deaths_rostest")
        cls.client = SurveyClient()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def tearDown(self):
        # A test that failed must not be in the way of the next one.
        if self.client.statuses and self.client.statuses[-1].code == ControlStatus.PAUSED:
            self.client.stop()
            self.client.wait_for_status(ControlStatus.STOPPED)

    def wait_until_named(self, node, begun_s):
        """Wait until a status warns that the node does not answer; return the last status."""
        statuses = self.client.statuses
        self.client.wait(lambda: any(node in missing_nodes(one) for one in statuses))
        noticed_s = time.monotonic() - begun_s
        print(f"{node}: noticed after {noticed_s:.2f} s")
        self.assertLess(noticed_s, NOTICE_LIMIT_S)
        return statuses[-1]

    def signal(self, node, number):
        """Send a signal to a node; return when that was [s]."""
        pid = node_pid(f"/{node}")
        self.client.forget()
        begun_s = time.monotonic()
        os.kill(pid, number)
        return begun_s

    def wait_until_all_answer(self):
        statuses = self.client.statuses
        self.client.wait(lambda: not missing_nodes(statuses[-1]))

    def check_complete(self, survey_id):
        status = self.client.wait_for_status(*ENDED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        stored = json_traces(self.client.folder(survey_id))
        self.assertEqual([one["index"] for one in stored], list(range(TRACES)))
        places = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
        self.assertEqual(len(places), TRACES)

    def check_death_in_a_survey(self, node):
        """Kill a node in a survey, which must wait and continue by itself."""
        survey_id = self.client.begin()
        self.client.wait_for_visited(4)
        begun_s = self.signal(node, signal.SIGKILL)
        self.wait_until_named(node, begun_s)
        self.check_complete(survey_id)
        codes = [status.code for status in self.client.statuses]
        self.assertNotIn(ControlStatus.PAUSED, codes)
        self.assertIn(ControlStatus.CHECKING, codes)

    def test_01_an_axis_with_an_endstop_dies(self):
        self.check_death_in_a_survey("x_axis/axis_driver")

    def test_03_the_z_axis_dies(self):
        self.check_death_in_a_survey("z_axis/axis_driver")

    def test_04_the_height_sensor_dies(self):
        self.check_death_in_a_survey("height_sensor")

    def test_05_the_analyzer_dies(self):
        self.check_death_in_a_survey("vna_acquisition")

    def test_06_the_storage_dies(self):
        self.check_death_in_a_survey("vna_processing")

    def test_07_the_simulated_robot_dies(self):
        self.check_death_in_a_survey("simulator")

    def test_10_a_death_at_rest_is_said_and_so_is_the_return(self):
        begun_s = self.signal("height_sensor", signal.SIGKILL)
        status = self.wait_until_named("height_sensor", begun_s)
        self.assertEqual(status.code, ControlStatus.FINISHED)
        self.wait_until_all_answer()
        self.assertEqual(self.client.statuses[-1].code, ControlStatus.FINISHED)

    def test_11_a_death_while_paused_is_said_and_the_survey_stays_paused(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(2)
        self.assertTrue(self.client.pause().success)
        self.client.wait_for_status(ControlStatus.PAUSED)
        for node in ("vna_processing", "x_axis/axis_driver"):
            begun_s = self.signal(node, signal.SIGKILL)
            status = self.wait_until_named(node, begun_s)
            self.assertEqual(status.code, ControlStatus.PAUSED)
            self.wait_until_all_answer()
        self.assertEqual(self.client.statuses[-1].code, ControlStatus.PAUSED)
        self.client.go_on(survey_id)
        self.check_complete(survey_id)

    def test_12_a_node_that_hangs_is_noticed_and_the_survey_goes_on_when_it_wakes(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        pid = node_pid("/vna_acquisition")
        begun_s = self.signal("vna_acquisition", signal.SIGSTOP)
        try:
            self.wait_until_named("vna_acquisition", begun_s)
        finally:
            os.kill(pid, signal.SIGCONT)
        self.check_complete(survey_id)

    def test_14_a_survey_that_holds_can_be_stopped(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        begun_s = self.signal("z_axis/axis_driver", signal.SIGKILL)
        self.wait_until_named("z_axis/axis_driver", begun_s)
        self.assertTrue(self.client.stop().success)
        status = self.client.wait_for_status(ControlStatus.STOPPED)
        stored = json_traces(self.client.folder(survey_id))
        self.assertIn(f"{len(stored)} of {TRACES} traces", status.message)
        self.wait_until_all_answer()
        self.client.go_on(survey_id)
        self.check_complete(survey_id)

    def test_20_a_control_that_died_begins_a_new_survey_and_the_old_one_stays_resumable(self):
        cut_off = self.client.begin()
        self.client.wait_for_visited(3)
        self.signal("main_control", signal.SIGKILL)
        self.client.wait_for_status(ControlStatus.IDLE)
        fresh = self.client.begin()
        self.check_complete(fresh)
        messages = [status.message for status in self.client.statuses]
        folder = self.client.folder(cut_off)
        self.assertTrue(any(folder.name in message for message in messages), messages)
        self.client.go_on(folder.name)
        self.check_complete(cut_off)


if __name__ == "__main__":
    rostest.rosrun("gpr20_main_control", "node_deaths", NodeDeathsTest)
