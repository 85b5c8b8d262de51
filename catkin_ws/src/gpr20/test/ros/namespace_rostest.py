#!/usr/bin/env python3
"""Two robots in their namespaces, and recordings that are played beside them."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import unittest
from pathlib import Path

import rosbag
import rospkg
import rospy
import rostest
from survey_client import LIMIT_S, SurveyClient, bits, json_traces, wait_for_bag, wait_until

from gpr20_analysis.read.verdict import INCOMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_msgs.msg import ControlStatus, Replay

WINDOW = Path(rospkg.RosPack().get_path("gpr20_user_interface")) / "test/ros/window_process.py"
ENVIRONMENT = dict(os.environ, QT_QPA_PLATFORM="offscreen")
ENDING_LIMIT_S = 20.0
ROBOTS = ("/robot1", "/robot2")
# Another part of the ground: the traces of the robots differ.
AREAS = {
    "/robot1": {"x_points": 5, "y_points": 5},
    "/robot2": {
        **{"x_start_mm": 30.0, "x_stop_mm": 40.0, "x_points": 5},
        **{"y_start_mm": 30.0, "y_stop_mm": 40.0, "y_points": 5},
    },
}
TRACES = 50


@contextlib.contextmanager
def process(*command, **options):
    """Run a command; it is interrupted, as by Ctrl-C, in the end."""
    with subprocess.Popen(command, env=ENVIRONMENT, text=True, **options) as started:
        try:
            yield started
        finally:
            if started.poll() is None:
                started.send_signal(signal.SIGINT)
            try:
                started.wait(ENDING_LIMIT_S)
            except subprocess.TimeoutExpired:
                started.kill()


class Window:
    """A window in a process of its own, which reports what it shows."""

    def __init__(self, opened):
        self._process = opened
        self.shown()

    @classmethod
    @contextlib.contextmanager
    def open(cls, namespace, *options):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        command = (sys.executable, str(WINDOW), *options, f"__ns:={namespace}")
        with process(*command, **pipes) as opened:
            yield cls(opened)
            # Without a question more to answer it ends.
            opened.stdin.close()
            opened.wait(LIMIT_S)

    def shown(self):
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())


class NamespaceTest(unittest.TestCase):
    """The tests run in the order of their names and replay the surveys of the first."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("namespace_rostest")
        cls.clients = {robot: SurveyClient(robot) for robot in ROBOTS}
        cls.folders = {}

    @classmethod
    def tearDownClass(cls):
        for client in cls.clients.values():
            shutil.rmtree(client.data)

    def check_own_survey(self, robot):
        """Check what the survey and its bag hold, to the end; return the bits of the traces."""
        folder, client = self.folders[robot], self.clients[robot]
        client.check_complete(client.survey_id, TRACES)
        status = client.statuses[-1]
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            topics = bag.get_type_and_topic_info().topics
            statuses = [one.message for one in bag.read_messages([f"{robot}/control_status"])]
            marks = list(bag.read_messages([f"{robot}/replay"], return_connection_header=True))
        self.assertEqual(topics[f"{robot}/trace"].message_count, TRACES)
        others = [topic for topic in topics if not topic.startswith((f"{robot}/", "/diagnostics"))]
        self.assertEqual(others, [])
        last = statuses[-1]
        self.assertEqual((last.code, str(last.fault)), (status.code, str(status.fault)))
        for one in marks:
            self.assertEqual((one.message.state, one.message.folder), (Replay.PLAYING, folder.name))
            self.assertEqual(one.connection_header["latching"], b"1")
        self.assertTrue(marks)
        return {bits(trace["s21_real"]) for trace in json_traces(folder)}

    def test_1_a_fault_and_a_stop_of_one_robot_leave_the_other_alone(self):
        first, second = (self.clients[robot] for robot in ROBOTS)
        for robot, client in self.clients.items():
            self.folders[robot] = client.begin(**AREAS[robot])
        for robot, client in self.clients.items():
            client.wait_for_visited(1)
            self.folders[robot] = client.folder(self.folders[robot])
        self.assertNotIn(ControlStatus.FINISHED, [one.statuses[-1].code for one in (first, second)])
        self.assertTrue(first.set_fault(device="adc", fault="STUCK", count=0).success)
        first.wait_for_status(ControlStatus.PAUSED)
        self.assertTrue(first.stop().success)
        first.wait_for_status(ControlStatus.STOPPED)
        measured = [self.check_own_survey("/robot2")]
        self.assertTrue(first.set_fault(device="adc", fault="NONE", count=0).success)
        first.go_on(self.folders["/robot1"].name)
        measured.append(self.check_own_survey("/robot1"))
        self.assertEqual(set.intersection(*measured), set())

    def test_2_a_recording_on_the_topics_of_a_robot_neither_moves_it_nor_is_shown(self):
        bag = str(self.folders["/robot2"] / "survey.bag")
        client = self.clients["/robot2"]
        survey_id = client.begin(x_points=40, y_points=20)
        client.wait_for_visited(1)
        with Window.open("/robot2") as window:
            wait_until(lambda: window.shown()["title"] == "SURVEYING", "the window does not follow")
            wait_until(lambda: window.shown()["area_traces"] == 1600, "the window has no plan")
            # Everything that it says: results, statuses, goals and coordinates of the axes.
            player = ("rosbag", "play", "-q", "-r", "4", bag)
            with process(*player, stdout=subprocess.DEVNULL) as played:
                visited = []
                while played.poll() is None:
                    shown = window.shown()
                    self.assertEqual((shown["replay"], shown["title"]), ("", "SURVEYING"), shown)
                    self.assertEqual((shown["stop"], shown["area_traces"]), (True, 1600))
                    visited.append(shown["visited"])
                self.assertEqual(visited, sorted(visited))
        self.assertNotIn(ControlStatus.PAUSED, [one.code for one in client.statuses])
        self.assertTrue(client.stop().success)
        client.wait_for_status(ControlStatus.STOPPED)
        found = verify_survey(client.folder(survey_id))
        self.assertEqual((found.status, found.faults, found.unproven), (INCOMPLETE, [], 0))
        self.assertGreaterEqual(found.stored, visited[-1])
        # The folder is removed when nobody writes into it any more.
        wait_for_bag(client.folder(survey_id))

    def test_3_a_window_shows_a_bag_that_is_played_and_its_end(self):
        bag = str(self.folders["/robot1"] / "survey.bag")
        with Window.open("/replay/robot1", "--replay") as window:
            self.assertIn("Waiting for a recording", window.shown()["survey"])
            # It does not wait until the window has connected.
            player = ("rosbag", "play", "-q", "-d", "2", "-r", "4", "--prefix=/replay", bag)
            with process(*player, stdout=subprocess.DEVNULL) as played:
                wait_until(lambda: window.shown()["on_radar"] == TRACES, "traces are missing")
                shown = window.shown()
                self.assertTrue(shown["replay"] and not shown["stop"], shown)
                played.wait(LIMIT_S)
            wait_until(lambda: "FINISHED" in window.shown()["survey"], "no end")
            after = window.shown()
        self.assertEqual((after["replay"], after["stop"]), ("REPLAY", False))
        self.assertEqual((after["alarm"], after["locked"]), ("", True))
        self.assertEqual((after["on_map"], after["visited"]), (TRACES, TRACES))


if __name__ == "__main__":
    rostest.rosrun("gpr20", "namespace", NamespaceTest)
