#!/usr/bin/env python3
"""What may be started beside a robot, and nodes that die or hang: a survey loses nothing.

Beside it: the sensors of the tutorial, any of its nodes, or the whole of it once more.
"""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import urlsplit

import psutil
import rosgraph
import rosnode
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, str(Path(__file__).resolve().parents[5] / "tools/kits"))
from survey_client import (
    LIMIT_S,
    SurveyClient,
    json_traces,
    node_pid,
    run,
    wait_until,
    wait_until_connected,
)
from tutorial_code import code_blocks

from gpr20_common.high.answers import message_from
from gpr20_msgs.msg import ControlStatus, NodeDescription, RobotConfiguration

ROOT = Path(__file__).resolve().parents[5]
SENSORS = {"soil_moisture": "m3/m3", "soil_temperature": "degC"}
# Of these three a second one is started.
AGAIN = {
    "/x_axis/axis_driver": ("gpr20_simulator", "simulated_axis_driver"),
    "/vna_processing": ("gpr20_vna_processing", "vna_processing"),
    "/main_control": ("gpr20_main_control", "main_control"),
}
NODE_NAMES = (
    *(*AGAIN, "/y_axis/axis_driver", "/z_axis/axis_driver", "/simulator", "/height_sensor"),
    *("/vna_acquisition", "/imaging"),
)

# What a second launch may say differently, in as few launches.
SECOND_ARGUMENTS = (
    (
        *("robot:=simulated", "data:=/tmp/gpr20_second_data", "time_scale:=3"),
        *("seconds_per_point:=1e-3", "vna_portmapper:=true", "vna_medium:=position_probe"),
        "language:=es",
    ),
    ("robot:=gpr20",),
)
POISON = {
    "/simulated": False,
    "/time_scale": 1.0,
    "/vna_processing/data": "/tmp/gpr20_second_data",
    "/main_control/settle_s": 60.0,
    "/x_axis/axis_driver/max_coord": 20.0,
    "/x_axis/axis_driver/scene": "/nowhere.yaml",
    "/height_sensor/time_scale": 3.0,
}


TRACES = 18
# Each dies while the survey measures; the survey waits for it and continues by itself.
DEATHS = (
    ("x_axis/axis_driver",),
    ("z_axis/axis_driver", "height_sensor"),
    ("vna_acquisition", "simulator"),
    ("vna_processing",),
)


def description(node):
    if node == "/main_control":  # it describes the whole robot
        robot = rospy.wait_for_message("robot_configuration", RobotConfiguration, LIMIT_S)
        own = [one.configuration_json for one in robot.nodes if one.node == "main_control"]
        return own, robot.site_json
    message = rospy.wait_for_message(f"{node}/description", NodeDescription, LIMIT_S)
    return message.simulated, message.time_scale, message.hardware, message.configuration_json


def is_back(node, before):
    """Return whether a process that was killed has a successor."""
    try:
        return node_pid(node) != before
    except (OSError, rosnode.ROSNodeException):
        return False


def missing_nodes(status):
    """Return the nodes that do not answer, by the warning of a status."""
    warning = message_from(status).values.get("warning")
    return () if warning is None else warning.all_details


def watched(node):
    """Return the process id of a node, when a watchdog has asked it: it keeps the connection."""

    def is_watched():
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
        ports = []
        for process in psutil.Process().parent().children():
            # Others end meanwhile.
            with contextlib.suppress(psutil.NoSuchProcess):
                if any(word.endswith("gpr20_launch/watchdog") for word in process.cmdline()):
                    ports += [one.raddr.port for one in process.net_connections() if one.raddr]
        return urlsplit(uri).port in ports

    wait_until(is_watched, f"nobody watches {node}")
    return node_pid(node)


class SecondLaunchTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("second_launch_rostest")
        cls.client = SurveyClient()
        page = ROOT / "docs/extend/sensor.md"
        configured = Path(__file__).with_name("second_launch_config") / "sensors.yaml"
        assert code_blocks(page, "yaml") == {configured.name: configured.read_text()}
        program = (sys.executable, "-c", code_blocks(page, "python")["soil_probe.py"])
        cls.probe = subprocess.Popen(program)

    @classmethod
    def tearDownClass(cls):
        cls.probe.terminate()
        cls.probe.wait(LIMIT_S)
        shutil.rmtree(str(cls.client.data), ignore_errors=True)

    def test_1_no_node_starts_beside_one_of_its_name_and_the_survey_goes_on(self):
        # Only a node itself says what it is.
        publisher = rospy.Publisher(
            "/height_sensor/description", NodeDescription, queue_size=1, latch=True
        )
        wait_until_connected([publisher])
        publisher.publish(NodeDescription(node="height_sensor", hardware="another", time_scale=1.0))
        self.client.begin(x_points=7, y_points=7)
        self.client.wait_for_visited(2)
        before = {name: node_pid(name) for name in AGAIN}
        commands = []
        for full, program in AGAIN.items():
            namespace, _slash, name = full.rpartition("/")
            commands.append(["rosrun", *program, f"__name:={name}", f"__ns:={namespace or '/'}"])
        with ThreadPoolExecutor() as second:
            ended = dict(zip(AGAIN, second.map(lambda one: run(*one), commands)))
        for name, (status, said) in ended.items():
            with self.subTest(name):
                self.assertEqual(status, 1, said)
                self.assertIn(f"{name} cannot start: it is already running", said)
                self.assertIn("give this one its own namespace", said)
                self.assertEqual(node_pid(name), before[name])
        self.client.finished()
        self.assertNotIn("robot.part_silent", [one.fault.code for one in self.client.statuses])
        publisher.unregister()

    def test_2_a_second_launch_changes_nothing_whatever_its_arguments_are(self):
        before = rospy.get_param("/")
        launch = ["roslaunch", "gpr20", "survey.launch", "ui:=false"]
        with ThreadPoolExecutor() as launches:
            ended = launches.map(lambda given: run(*launch, *given), SECOND_ARGUMENTS)
        for given, (status, said) in zip(SECOND_ARGUMENTS, ended):
            with self.subTest(given):
                self.assertNotEqual(status, 0)
                self.assertIn("This robot cannot be launched: a robot is running on", said)
                self.assertIn("kill ", said)
        self.assertEqual(rospy.get_param("/"), before)

    def test_3_every_node_that_restarts_is_what_its_robot_was_launched_as(self):
        # What the former launch files set under names that all launches share.
        for name, value in POISON.items():
            rospy.set_param(name, value)
        data = self.client.data
        before = {node: (node_pid(node), description(node)) for node in NODE_NAMES}
        for pid, _described in before.values():
            os.kill(pid, signal.SIGKILL)
        for node, (pid, described) in before.items():
            with self.subTest(node):
                wait_until(lambda node=node, pid=pid: is_back(node, pid), f"{node} is gone")
                self.assertEqual(description(node), described)
        self.client = type(self).client = SurveyClient()
        self.assertEqual(self.client.data, data)
        self.wait_for_sensors()
        survey_id = self.client.begin()
        self.assertTrue(self.client.finished().simulated)
        folder = self.client.folder(survey_id)
        recorded = json.loads((folder / "survey.json").read_text())
        self.assertIs(recorded["simulated"], True)
        self.assertEqual({one["simulated"] for one in recorded["nodes"]}, {True})
        self.assertEqual({one["time_scale"] for one in recorded["nodes"]}, {20.0})
        self.assertEqual(recorded["storage"]["data"], str(data))
        self.assertEqual(recorded["axes"]["x"]["max_coord"], 650.0)
        self.assertEqual(recorded["analyzer"]["max_frequency_hz"], 6e9)
        self.assertEqual(recorded["site"]["site"], "El Carmen ñ")
        self.assertIsNone(recorded["site"]["latitude_deg"])
        self.assertEqual([one["name"] for one in recorded["sensors"]], list(SENSORS))
        self.check_sensors(folder)

    def wait_for_sensors(self):
        """Return when /diagnostics, and so ROBOT, shows a value of each sensor."""
        well = set()

        def note(message):
            well.update(one.name.partition(": ")[0] for one in message.status if not one.level)

        subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, note)
        wait_until(lambda: {f"sensors/{name}" for name in SENSORS} <= well, "a sensor is missing")
        subscriber.unregister()

    def check_sensors(self, folder):
        for trace in json_traces(folder):
            # The temperature of the VNA is among them too.
            sensed = {one["name"]: one for one in trace["aux"] if one["name"] in SENSORS}
            self.assertEqual({name: one["unit"] for name, one in sensed.items()}, SENSORS)
            self.assertAlmostEqual(sensed["soil_moisture"]["value"], 0.25, delta=0.05)
            self.assertEqual(sensed["soil_temperature"]["value"], 18.5)
            self.assertLessEqual(sensed["soil_temperature"]["stamp"], trace["timestamp"])
            self.assertEqual(trace["quality"], [])
        table = self.client.data / "table.csv"
        status, said = run("gpr20", "export", str(folder), str(table), "--format", "csv")
        self.assertEqual(status, 0, said)
        self.assertIn("aux_soil_temperature [degC]", table.read_text())

    def signal(self, number, *nodes):
        """Send a signal to nodes, and wait until statuses warn that these do not answer."""
        pids = [node_pid(f"/{node}") for node in nodes]
        self.client.forget()
        for pid in pids:
            os.kill(pid, number)
        statuses = self.client.statuses
        for node in nodes:
            self.client.wait(lambda: any(node in missing_nodes(one) for one in statuses))  # noqa: B023
        return pids

    def wait_until_all_answer(self):
        self.client.wait(lambda: not missing_nodes(self.client.statuses[-1]))

    def test_4_a_survey_waits_for_every_node_that_dies_and_continues_by_itself(self):
        survey_id = self.client.begin()
        visited = 3
        for nodes in DEATHS:
            self.client.wait_for_visited(visited)
            self.signal(signal.SIGKILL, *nodes)
            self.client.wait(
                lambda: any(one.code == ControlStatus.CHECKING for one in self.client.statuses)
            )
            self.wait_until_all_answer()
            visited += 3
        self.client.check_complete(survey_id, TRACES)

    def test_5_hang_stop_and_death_of_the_control_lose_nothing(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        (pid,) = self.signal(signal.SIGSTOP, "vna_acquisition")
        with contextlib.suppress(ProcessLookupError):  # ended, if this computer is slow
            os.kill(pid, signal.SIGCONT)
        self.client.wait_for_visited(6)
        self.signal(signal.SIGKILL, "z_axis/axis_driver")
        # A survey that holds can be stopped.
        self.assertTrue(self.client.stop().success)
        status = self.client.wait_for_status(ControlStatus.STOPPED)
        folder = self.client.folder(survey_id)
        self.assertIn(f"{len(json_traces(folder))} of {TRACES} traces", status.message)
        self.wait_until_all_answer()
        pid = watched("/main_control")
        self.client.go_on(survey_id)
        self.client.wait_for_status(ControlStatus.SURVEYING)
        # The watchdog ends it.
        os.kill(pid, signal.SIGSTOP)
        self.client.forget()
        wait_until(lambda: not psutil.pid_exists(pid), f"process {pid} was not ended")
        self.client.wait_for_status(ControlStatus.IDLE)
        # Another one is begun first, and the one that was cut off stays resumable.
        self.client.check_complete(self.client.begin(), TRACES)
        self.client.go_on(folder.name)
        self.client.check_complete(survey_id, TRACES)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "second_launch", SecondLaunchTest)
