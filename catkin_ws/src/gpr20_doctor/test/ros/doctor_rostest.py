#!/usr/bin/env python3
"""The program doctor: its exit status and findings, with faults and without a robot."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import zipfile
from contextlib import contextmanager

import rosgraph
import rospkg
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from gpr20_common.errors import NodeSilentError
from gpr20_common.low.node_probe import NodeProbe
from gpr20_msgs.msg import ControlStatus, NodeDescription, RobotConfiguration
from gpr20_simulator.srv import SetFault

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import SurveyClient

LIMIT_S = 60.0
# They depend on the computer that runs the test.
COMPUTER = ("disk", "data_disk", "disk_speed", "memory", "volumes")
MASTER = os.environ["ROS_MASTER_URI"]


def doctor(*arguments, **environment):
    """Return exit status and the worst finding of each check."""
    ended = subprocess.run(
        ["rosrun", "gpr20_doctor", "doctor", "--json", "--language", "en", *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    record = json.loads(ended.stdout)
    assert record["status"] == ended.returncode, ended.stderr
    found = {}
    for one in record["findings"]:
        if one["check"] not in COMPUTER:
            # The worst of several comes first.
            found.setdefault(one["check"], one)
    return ended.returncode, found


def levels(found, *wanted):
    return {check for check, one in found.items() if one["level"] in wanted}


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def master_at(port, delay_s=0):
    """Run a ROS master without a robot."""
    command = f"sleep {delay_s}; exec rosmaster --core -p {port}"
    with subprocess.Popen(["bash", "-c", command], start_new_session=True) as core:
        try:
            yield core
        finally:
            os.killpg(core.pid, signal.SIGKILL)


def answers(probe):
    """Return the process of a node; 0: it does not answer."""
    try:
        return probe.process()
    except NodeSilentError:
        return 0


def process_of(node):
    return answers(NodeProbe(MASTER, "/test", rospy.resolve_name(node), 2.0))


def wait_until(condition):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s
        time.sleep(0.2)


class DoctorTest(unittest.TestCase):
    """The tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("doctor_rostest")
        cls.client = SurveyClient()
        cls.set_fault = rospy.ServiceProxy("simulator/set_fault", SetFault)
        cls.set_fault.wait_for_service(LIMIT_S)

        cls.config = tempfile.mkdtemp()
        os.environ["GPR20_CONFIG"] = cls.config

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)
        shutil.rmtree(cls.config)

    def test_1_a_robot_without_a_fault_is_good(self):
        status, found = doctor("--wait", "30")
        # The surveys of this test are in /tmp, which a real robot must not use.
        self.assertEqual(found.pop("config_files")["fault_code"], "config.data_folder")
        self.assertEqual(levels(found, "FAULT", "WARNING", "UNKNOWN"), set(), found)
        # Of disk and memory alone it may be worse.
        self.assertIn(status, (1, 2))
        self.assertIn("SIMULATED", found["identity"]["text"])
        self.assertEqual(found["calibration"]["level"], "OK")
        self.assertEqual(found["height"]["level"], "OK")
        self.assertEqual(found["versions"]["level"], "OK")
        self.assertLessEqual(
            {"simulated", "hardware", "vna_port", "x_axis/axis_driver"}, levels(found, "NOTE")
        )

    def test_2_what_was_not_asked_for_is_not_called_good_and_a_bundle_has_the_reports(self):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "help.zip")
            status, found = doctor("--quick", "--bundle", file)
            with zipfile.ZipFile(file) as archive:
                nodes = json.loads(archive.read("diagnostics.json").decode())
        self.assertEqual(levels(found, "UNKNOWN"), {"calibration"})
        self.assertIn(status, (1, 2))
        self.assertIn("x_axis/axis_driver", [one["node"] for one in nodes])

    def test_3_faults_are_named_with_their_remedies(self):
        faults = [("vna", "HANG"), ("adc", "STUCK"), ("endstop_x", "STUCK_CLOSED")]
        for device, fault in faults:
            self.set_fault(device, fault, 0)
        status, found = doctor()
        for device, _fault in faults:
            self.set_fault(device, "none", 0)
        self.assertEqual(status, 2)
        self.assertEqual(levels(found, "FAULT") - {"vna_acquisition"}, {"height_sensor", "vna"})
        self.assertIn("no connection to the VNA", found["vna"]["text"])
        self.assertIn("stuck", found["height_sensor"]["text"])
        self.assertIn("endstop_x", levels(found, "WARNING"))
        for one in found.values():
            self.assertTrue(one["remedy"] or one["level"] in ("OK", "NOTE"), one)

    def test_4_the_master_that_has_the_robot_is_named_and_the_advice_leads_there(self):
        wrong = f"http://127.0.0.1:{free_port()}"
        status, found = doctor("--quick", ROS_MASTER_URI=wrong)
        self.assertEqual(status, 2)
        self.assertEqual(found["master"]["fault_code"], "doctor.master_elsewhere")
        self.assertIn(wrong, found["master"]["text"])
        self.assertIn(f":{MASTER.split(':')[-1].strip('/')} (/)", found["master"]["text"])
        self.assertEqual(found["parts"]["level"], "UNKNOWN")
        self.assertEqual(levels(found, "FAULT"), {"master"})
        self.assertRegex(found["master"]["remedy"], "export ROS_MASTER_URI=http://.*[0-9]")
        _status, found = doctor("--quick", ROS_MASTER_URI=MASTER)
        self.assertEqual(found["master"]["level"], "OK")

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
        behind = DiagnosticArray(
            status=[DiagnosticStatus(name="mixed/height_sensor: Status", message="ok")]
        )
        reports = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=1)

        def report(_event):
            behind.header.stamp = rospy.Time.now() - rospy.Duration(75)
            reports.publish(behind)

        timer = rospy.Timer(rospy.Duration(0.2), report)
        _status, found = doctor("--ns", "mixed", "--quick", "--wait", "2")
        timer.shutdown()
        self.assertEqual(found["clocks"]["fault_code"], "clock.computers_differ")
        self.assertIn("75.", found["clocks"]["text"])
        self.assertEqual(found["clocks"]["details"], "pi")
        self.assertIn("Not running: ", found["missing"]["text"])
        self.assertEqual(found["versions"]["level"], "WARNING")
        self.assertIn("0.1.0 (a1) on pc; 0.1.0 (b2) on pi", found["versions"]["text"])

    def test_6_a_master_that_starts_later_is_waited_for(self):
        port = free_port()
        with master_at(port, delay_s=1):
            master = f"http://127.0.0.1:{port}"
            _status, found = doctor("--quick", "--wait", "6", ROS_MASTER_URI=master)
        self.assertIn("has no robot", found["master"]["text"])

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

    def test_8_a_wrong_namespace_is_one_fault_and_the_advice_leads_to_the_robot(self):
        status, found = doctor("--quick", ROS_NAMESPACE="field/b")
        self.assertEqual((status, levels(found, "FAULT", "WARNING")), (2, {"master"}))
        self.assertEqual(found["master"]["fault_code"], "doctor.other_namespace")
        self.assertIn("/field/b", found["master"]["text"])
        namespace = re.search(r"gpr20 doctor --ns (\S+)\.", found["master"]["remedy"]).group(1)
        _status, found = doctor("--quick", "--ns", namespace)
        self.assertEqual(found["master"]["level"], "OK")

    def test_9_a_part_that_hangs_is_found_until_the_robot_has_restarted_it(self):
        halted = process_of("height_sensor")
        os.kill(halted, signal.SIGSTOP)
        _status, found = doctor("--quick")
        self.assertEqual(found["height_sensor"]["fault_code"], "doctor.node_hangs")
        self.assertIn("Wait one minute", found["height_sensor"]["remedy"])
        wait_until(lambda: process_of("height_sensor") not in (0, halted))
        _status, found = doctor("--quick", "--wait", "30")
        self.assertEqual(levels(found, "FAULT"), set())

    def test_a_a_master_that_hangs_is_told_from_one_that_is_missing(self):
        port = free_port()
        master = f"http://127.0.0.1:{port}"
        with master_at(port) as core:
            wait_until(lambda: socket.socket().connect_ex(("127.0.0.1", port)) == 0)
            os.killpg(core.pid, signal.SIGSTOP)
            _status, found = doctor("--quick", ROS_MASTER_URI=master)
        self.assertEqual(found["master"]["fault_code"], "doctor.master_hangs")
        self.assertTrue(found["master"]["remedy"].startswith("Switch off the motors' power."))
        _status, found = doctor("--quick", ROS_MASTER_URI=master)
        self.assertEqual(found["master"]["fault_code"], "doctor.master_elsewhere")

    def test_b_each_mistake_of_the_configuration_is_found_until_it_is_corrected(self):
        axes = os.path.join(self.config, "axes.yaml")
        with open(axes, "w", encoding="utf-8") as file:
            file.write("x: {dir_pin: 11}\nz: {dir_pin: 11}\n")
        _status, found = doctor("--quick")
        wrong = found["config_files"]
        self.assertEqual((wrong["level"], wrong["fault_code"]), ("FAULT", "config.pin_conflict"))
        for words in (axes, "x/dir_pin", "z/dir_pin", "pin 11"):
            self.assertIn(words, wrong["text"])
        self.assertIn("pin of its own", wrong["remedy"])
        os.unlink(axes)
        _status, found = doctor("--quick")
        self.assertNotEqual(found["config_files"]["fault_code"], "config.pin_conflict")

    def test_c_a_configuration_that_is_named_is_judged_as_that_of_a_real_robot(self):
        analyzer = os.path.join(self.config, "analyzer.yaml")
        with open(analyzer, "w", encoding="utf-8") as file:
            file.write("address: 224.0.0.1\n")
        nobody = {"ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}"}
        named = ("--quick", "--config", self.config)
        for more, environment in (named, {}), (named, nobody), (("--quick",), nobody):
            _status, found = doctor(*more, **environment)
            self.assertEqual(found["config_files"]["fault_code"], "config.address")
        _status, found = doctor(*named, "--robot", "simulated", **nobody)
        self.assertEqual(found["config_files"]["level"], "OK")
        self.assertIn("robot:=simulated", found["config_files"]["text"])
        os.unlink(analyzer)
        _status, found = doctor("--quick", GPR20_DATA="surveys", **nobody)
        self.assertEqual(found["config_files"]["fault_code"], "config.data_folder")
        self.assertIn("environment: GPR20_DATA is surveys", found["config_files"]["text"])

    def test_d_parts_whose_launch_has_died_are_found_and_the_advice_ends_them(self):
        port = free_port()
        master = f"http://127.0.0.1:{port}"
        with tempfile.NamedTemporaryFile("w", suffix=".launch") as file:
            file.write('<launch><node pkg="rosout" type="rosout" name="part"/></launch>')
            file.flush()
            launch = subprocess.Popen(["roslaunch", "-p", str(port), file.name])
            probe = NodeProbe(master, "/test", "/part", 2.0)
            wait_until(lambda: answers(probe))
            _status, found = doctor("--quick", ROS_MASTER_URI=master)
            self.assertNotIn("launch", found)
            launch.kill()
            launch.wait()
        _status, found = doctor("--quick", ROS_MASTER_URI=master)
        self.assertEqual(found["launch"]["fault_code"], "doctor.left_over")
        command = re.search(r"Run: (kill [0-9 ]+)\.", found["launch"]["remedy"]).group(1)
        subprocess.run(["sh", "-ec", command], check=True)
        wait_until(lambda: not answers(probe))
        _status, found = doctor("--quick", ROS_MASTER_URI=master)
        self.assertNotIn("launch", found)
        os.kill(rosgraph.Master("/test", master).getPid(), signal.SIGTERM)


if __name__ == "__main__":
    rostest.rosrun("gpr20_doctor", "doctor", DoctorTest)
