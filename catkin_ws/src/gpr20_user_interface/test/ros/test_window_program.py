#!/usr/bin/env python3
"""The window as a program: on the graph while it is open, and gone when asked."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
import unittest
from typing import Optional

import rosgraph
import rosnode
import rospkg
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from fake_main_control import FakeMainControl
from virtual_screen import VirtualScreen, program_path
from waiting import LIMIT_S, wait_until

from gpr20_msgs.msg import ControlStatus

NO_DISPLAY, DISPLAY_LOST = 3, 4
# Ended by the signal: before it could take it, or after.
NO_CRASH = (0, 1, NO_DISPLAY, DISPLAY_LOST, -signal.SIGTERM)
LOST_DISPLAYS = int(os.environ.get("GPR20_LOST_DISPLAYS", "2"))


def is_on_graph() -> bool:
    return "/alone/window" in rosnode.get_node_names()


class Program(unittest.TestCase):
    def test_runs_and_leaves_the_survey_alone(self) -> None:
        fake = FakeMainControl("/alone")
        self.addCleanup(fake.close)
        ways_to_end = (
            lambda window: window.send_signal(signal.SIGINT),
            lambda window: window.send_signal(signal.SIGTERM),
            lambda _window: rosnode.kill_nodes(["/alone/window"]),
        )
        for end in ways_to_end:
            process = self.program()
            wait_until(is_on_graph, "the node is on the graph")
            wait_until(lambda: fake.listeners() == 1, "the window listens")
            end(process)
            output, _ = process.communicate(timeout=LIMIT_S)
            self.assertEqual(process.returncode, 0, output)
            for trouble in ("Traceback", "Error", "QObject"):
                self.assertNotIn(trouble, output)
            wait_until(lambda: fake.listeners() == 0, "the window has left")
            wait_until(lambda: not is_on_graph(), "the node has left the graph")
        self.assertEqual((fake.stops, fake.code), (0, ControlStatus.IDLE))

    def test_signal_while_it_starts_is_not_lost(self) -> None:
        process = self.program()
        wait_until(is_on_graph, "the node is on the graph")
        process.send_signal(signal.SIGTERM)
        output, _ = process.communicate(timeout=LIMIT_S)
        self.assertEqual(process.returncode, 0, output)
        wait_until(lambda: not is_on_graph(), "the node has left the graph")

    def test_unknown_language_ends_it_with_a_sentence(self) -> None:
        process = self.program("_language:=fr")
        output, _ = process.communicate(timeout=LIMIT_S)
        self.assertEqual(process.returncode, 2, output)
        self.assertIn("language is 'fr'; it must be one of en (English), es (Español)", output)
        self.assertNotIn("Traceback", output)

    def test_a_replay_in_the_namespace_of_a_robot_is_refused(self) -> None:
        # Two windows of one name: the master would end that of the robot.
        robot = rosgraph.Master("/alone/main_control")
        robot.registerSubscriber("/alone/anything", "*", "http://127.0.0.1:9")
        self.addCleanup(robot.unregisterSubscriber, "/alone/anything", "http://127.0.0.1:9")
        process = self.program("--replay")
        output, _ = process.communicate(timeout=LIMIT_S)
        self.assertEqual(process.returncode, 2, output)
        self.assertIn("a robot has the namespace", output)

    def test_no_parameter_that_is_left_makes_the_window_of_a_robot_that_of_a_replay(self) -> None:
        for name in ("/alone/replay", "/alone/window/replay"):
            rospy.set_param(name, True)
            self.addCleanup(rospy.delete_param, name)
        process = self.program()
        report = rospy.wait_for_message("/diagnostics", DiagnosticArray, LIMIT_S)
        self.assertIn("no contact", report.status[0].message)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LIMIT_S)
        wait_until(lambda: not is_on_graph(), "the node has left the graph")

    def test_without_a_display_it_says_how_to_run_without_a_window(self) -> None:
        for display in ("", ":4711"):
            process = self.program(display=display)
            output, _ = process.communicate(timeout=LIMIT_S)
            self.assertEqual(process.returncode, NO_DISPLAY, output)
            said = [line for line in output.splitlines() if "QStandardPaths" not in line]
            self.assertEqual(len(said), 1, output)
            self.assertIn("ui:=false", said[0])

    def test_it_waits_for_a_display_where_the_launch_says_so(self) -> None:
        process = self.program("--wait-for-display", display=":4711")
        line = process.stdout.readline()
        self.assertIn("ui:=false", line)
        process.terminate()
        output, _ = process.communicate(timeout=LIMIT_S)
        self.assertEqual((process.returncode, output), (-signal.SIGTERM, ""))

    def test_a_display_that_is_lost_never_crashes_it(self) -> None:
        draw = random.Random(os.environ.get("GPR20_SEED", "1"))
        for number in range(LOST_DISPLAYS):
            lost = VirtualScreen()
            process = self.program(display=lost.name)
            if number % 2:
                wait_until(is_on_graph, "the node is on the graph")
            # At any moment: while it starts, while it is shown.
            time.sleep(draw.uniform(0.0, 0.8))
            ends = [lost.kill, process.terminate][: draw.choice((1, 2))]
            draw.shuffle(ends)
            for end in ends:
                end()
            output, _ = process.communicate(timeout=LIMIT_S)
            lost.close()
            self.assertIn(process.returncode, NO_CRASH, output)
            for trouble in ("Traceback", "Segmentation", "Aborted"):
                self.assertNotIn(trouble, output)
            wait_until(lambda: not is_on_graph(), "the node has left the graph")

    def test_a_window_without_a_robot_shows_the_one_that_is_chosen(self) -> None:
        fakes = {name: FakeMainControl(name) for name in ("/alone", "/beside")}
        for fake in fakes.values():
            self.addCleanup(fake.close)
            fake.pause("waiting for the operator")
        process = self.program("_settings:=/tmp/gpr20_no_settings.yaml", namespace="/nowhere")
        robot = fakes["/beside"]
        # The sheet opens by itself; while it is open the window follows every robot.
        wait_until(lambda: fakes["/alone"].watchers() == 1, "the sheet is open")
        # The second button of its first row is that of /beside. It takes no touch at first.
        wait_until(
            lambda: robot.listeners() == 1,
            "the window of the robot listens",
            lambda: self.touch(600, 150),
        )
        self.assertNotIn("/nowhere/window", rosnode.get_node_names())
        # It listens a little before it takes a touch.
        wait_until(lambda: robot.stops > 0, "STOP reaches it", lambda: self.touch(750, 36))
        self.assertEqual(fakes["/alone"].stops, 0)
        process.terminate()
        output, _ = process.communicate(timeout=LIMIT_S)
        self.assertEqual(process.returncode, 0, output)

    def touch(self, x: int, y: int) -> None:
        finger = (program_path("xdotool"), "mousemove", str(x), str(y), "click", "1")
        subprocess.run(finger, check=True, timeout=LIMIT_S)
        # As a person does: a new window needs the processor in between.
        time.sleep(0.5)

    def program(
        self, *arguments: str, display: Optional[str] = None, namespace: str = "/alone"
    ) -> subprocess.Popen:
        folder = rospkg.RosPack().get_path("gpr20_user_interface")
        path = os.path.join(folder, "nodes", "user_interface")
        process = subprocess.Popen(
            [sys.executable, path, f"__ns:={namespace}", "__name:=window", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
            env=os.environ if display is None else {**os.environ, "DISPLAY": display},
        )
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process


if __name__ == "__main__":
    screen = VirtualScreen()
    try:
        os.environ["DISPLAY"] = screen.name
        rospy.init_node("test_window_program", disable_signals=True)
        rostest.rosrun("gpr20_user_interface", "window_program", Program)
    finally:
        screen.close()
