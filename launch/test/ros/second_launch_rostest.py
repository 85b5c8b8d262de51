#!/usr/bin/env python3
"""What may be started beside a robot: it once more, one of no known name, a recording."""

import os
import shutil
import subprocess
import sys
import unittest

import rospy
import rostest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from survey_client import SurveyClient, json_traces, node_pid, wait_until_connected

from gpr20_msgs.msg import ControlStatus, CurrentCoordinate

LIMIT_S = 60.0
NODES = (
    *(
        ("gpr20_simulator", "simulated_axis_driver", "axis_driver", f"/{axis}_axis")
        for axis in "xyz"
    ),
    ("gpr20_simulator", "simulator", "simulator", "/"),
    ("gpr20_simulator", "simulated_height_sensor", "height_sensor", "/"),
    ("gpr20_simulator", "simulated_vna_acquisition", "vna_acquisition", "/"),
    ("gpr20_vna_processing", "vna_processing", "vna_processing", "/"),
    ("gpr20_main_control", "main_control", "main_control", "/"),
)


def run(command):
    """Run a command; return its exit status and all that it said."""
    ended = subprocess.run(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    return ended.returncode, ended.stdout


class SecondLaunchTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("second_launch_rostest")
        cls.client = SurveyClient()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(str(cls.client.data), ignore_errors=True)

    def test_1_no_node_starts_beside_one_of_its_name_and_the_survey_goes_on(self):
        survey_id = self.client.begin(x_points=10, y_points=10)
        self.client.wait_for_visited(2)
        for package, program, name, namespace in NODES:
            full_name = f"{namespace.rstrip('/')}/{name}"
            with self.subTest(full_name):
                before = node_pid(full_name)
                command = ["rosrun", package, program, f"__name:={name}", f"__ns:={namespace}"]
                status, said = run(command)
                self.assertEqual(status, 1, said)
                self.assertIn(f"{full_name} cannot start: it is already running", said)
                self.assertIn("give this one its own namespace", said)
                self.assertEqual(node_pid(full_name), before)
        status = self.client.wait_for_status(ControlStatus.FINISHED, ControlStatus.PAUSED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        self.assertTrue(self.client.folder(survey_id).is_dir())
        texts = [one.message for one in self.client.statuses]
        self.assertFalse([text for text in texts if "does not answer" in text])

    def test_2_an_unknown_robot_is_told_with_those_that_are_known(self):
        for name in ("survey.launch", "robot.launch", "server.launch"):
            with self.subTest(name):
                status, said = run(["roslaunch", "--nodes", "gpr20", name, "robot:=foo"])
                self.assertNotEqual(status, 0)
                self.assertIn("unknown robot:=foo (write robot:=simulated or robot:=gpr20)", said)

    def test_3_coordinates_that_are_played_beside_the_robot_are_not_taken_for_its_own(self):
        played = rospy.Publisher("/x_axis/current_coord", CurrentCoordinate, queue_size=10)
        elsewhere = CurrentCoordinate(coordinate=20.0, homed=True, moving=False)
        timer = rospy.Timer(rospy.Duration(0.005), lambda _event: played.publish(elsewhere))
        try:
            wait_until_connected([played])
            survey_id, status = self.client.run_to_end()
        finally:
            timer.shutdown()
            played.unregister()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        self.assertEqual(len(json_traces(self.client.folder(survey_id))), 18)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "second_launch", SecondLaunchTest)
