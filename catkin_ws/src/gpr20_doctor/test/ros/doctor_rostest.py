#!/usr/bin/env python3
"""The program doctor: its exit status and findings, with faults and without a robot."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import unittest

import rospkg
import rospy
import rostest

from gpr20_msgs.msg import ControlStatus, NodeDescription, RobotConfiguration
from gpr20_simulator.srv import SetFault

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import SurveyClient

LIMIT_S = 60.0
# Free space depends on the computer that runs the test.
DISK = ("disk", "data_disk", "disk_speed")


def doctor(*arguments, **environment):
    """Return exit status, findings by their checks, and the time that it took [s]."""
    began_s = time.monotonic()
    ended = subprocess.run(
        ["rosrun", "gpr20_doctor", "doctor", "--json", "--language", "en", *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    took_s = time.monotonic() - began_s
    record = json.loads(ended.stdout)
    assert record["status"] == ended.returncode, ended.stderr
    found = {one["check"]: one for one in record["findings"] if one["check"] not in DISK}
    return ended.returncode, found, took_s


def levels(found, *wanted):
    return {check for check, one in found.items() if one["level"] in wanted}


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class DoctorTest(unittest.TestCase):
    """The tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("doctor_rostest")
        cls.client = SurveyClient()
        cls.set_fault = rospy.ServiceProxy("simulator/set_fault", SetFault)
        cls.set_fault.wait_for_service(LIMIT_S)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def test_1_a_robot_without_a_fault_is_good(self):
        status, found, _took_s = doctor("--wait", "30")
        self.assertEqual(levels(found, "FAULT", "WARNING", "UNKNOWN"), set(), found)
        # Of the disk alone.
        self.assertIn(status, (0, 1, 2))
        self.assertIn("SIMULATED", found["identity"]["text"])
        self.assertEqual(found["calibration"]["level"], "OK")
        self.assertEqual(found["height"]["level"], "OK")
        self.assertEqual(found["versions"]["level"], "OK")
        self.assertLessEqual(
            {"simulated", "hardware", "vna_port", "x_axis/axis_driver"}, levels(found, "NOTE")
        )

    def test_2_what_was_not_asked_for_is_not_called_good(self):
        status, found, _took_s = doctor("--quick")
        self.assertEqual(levels(found, "UNKNOWN"), {"calibration"})
        self.assertIn(status, (1, 2))

    def test_3_faults_are_named_with_their_remedies(self):
        faults = [("vna", "HANG"), ("adc", "STUCK"), ("endstop_x", "STUCK_CLOSED")]
        for device, fault in faults:
            self.set_fault(device, fault, 0)
        status, found, took_s = doctor()
        for device, _fault in faults:
            self.set_fault(device, "none", 0)
        self.assertEqual(status, 2)
        self.assertEqual(levels(found, "FAULT") - {"vna_acquisition"}, {"height_sensor", "vna"})
        self.assertIn("no connection to the VNA", found["vna"]["text"])
        self.assertIn("stuck", found["height_sensor"]["text"])
        self.assertIn("endstop_x", levels(found, "WARNING"))
        for one in found.values():
            self.assertTrue(one["remedy"] or one["level"] in ("OK", "NOTE"), one)
        self.assertLess(took_s, 30.0)

    def test_4_a_robot_that_is_off_is_said_to_be_off(self):
        master = f"http://127.0.0.1:{free_port()}"
        status, found, took_s = doctor(ROS_MASTER_URI=master)
        self.assertEqual(status, 2)
        self.assertEqual(found["master"]["details"], master)
        self.assertEqual(found["master"]["level"], "FAULT")
        self.assertEqual(found["parts"]["level"], "UNKNOWN")
        self.assertLess(took_s, 10.0)

    def test_5_different_software_on_two_computers_is_a_warning(self):
        nodes = [
            NodeDescription(
                node=node, configuration_json="{}", version="0.1.0", revision=revision, host=host
            )
            for node, revision, host in (
                ("main_control", "a1", "pc"),
                ("height_sensor", "b2", "pi"),
            )
        ]
        latched = {"queue_size": 1, "latch": True}
        configuration = rospy.Publisher("/mixed/robot_configuration", RobotConfiguration, **latched)
        configuration.publish(RobotConfiguration(known=True, nodes=nodes))
        control = rospy.Publisher("/mixed/control_status", ControlStatus, **latched)
        control.publish(ControlStatus())
        _status, found, _took_s = doctor("--ns", "mixed", "--quick", "--wait", "2")
        self.assertEqual(found["versions"]["level"], "WARNING")
        self.assertIn("0.1.0 (a1) on pc; 0.1.0 (b2) on pi", found["versions"]["text"])

    def test_6_a_master_that_starts_later_is_waited_for(self):
        port = free_port()
        late = f"sleep 1; exec rosmaster --core -p {port}"
        with subprocess.Popen(["bash", "-c", late], start_new_session=True) as core:
            master = f"http://127.0.0.1:{port}"
            _status, found, _took_s = doctor("--quick", "--wait", "6", ROS_MASTER_URI=master)
            os.killpg(core.pid, signal.SIGTERM)
        self.assertEqual(levels(found, "FAULT") & {"master", "control"}, {"control"})

    def test_7_a_folder_of_no_user_is_a_sentence_and_no_verdict(self):
        master = f"http://127.0.0.1:{free_port()}"
        ended = subprocess.run(
            ["rosrun", "gpr20_doctor", "doctor", "--quick", "--language", "en"],
            env={**os.environ, "ROS_MASTER_URI": master, "GPR20_CONFIG": "~no_such_user/robot"},
            stderr=subprocess.PIPE,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )
        self.assertEqual(ended.returncode, 3)
        self.assertTrue(ended.stderr.startswith("The doctor could not work: "), ended.stderr)


if __name__ == "__main__":
    rostest.rosrun("gpr20_doctor", "doctor", DoctorTest)
