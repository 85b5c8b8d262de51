#!/usr/bin/env python3
"""The real robot's nodes without its hardware end with a reason; they never simulate."""

import importlib.util
import subprocess
import unittest

import rosgraph
import rospy
import rostest

LIMIT_S = 30.0


def is_missing(library):
    return importlib.util.find_spec(library) is None


class NoHardwareTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("faults_no_hardware_rostest")

    def check_refusal(self, package, node, *arguments):
        ended = subprocess.run(
            ["rosrun", package, node, "configuration:=/no_hardware", *arguments],
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
        )
        said = ended.stdout + ended.stderr
        self.assertNotEqual(ended.returncode, 0, said)
        self.assertIn("cannot start", said)
        self.assertIn("elsewhere launch with robot:=simulated", said)
        self.assertNotIn("is ready", said)
        self.assertNotIn("Traceback", said)

    @unittest.skipUnless(is_missing("RPi"), "this computer has the robot's pins")
    def test_an_axis_without_pins_does_not_start(self):
        self.check_refusal("gpr20_axis_driver", "axis_driver", "__ns:=x_axis")

    @unittest.skipUnless(is_missing("spidev"), "this computer has the robot's bus")
    def test_a_height_sensor_without_a_bus_does_not_start(self):
        self.check_refusal("gpr20_height_sensor", "height_sensor")

    def test_none_of_their_services_is_left(self):
        services = {name for name, _ in rosgraph.Master(rospy.get_name()).getSystemState()[2]}
        self.assertFalse(services & {"/get_height", "/x_axis/homing"}, services)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "faults_no_hardware", NoHardwareTest)
