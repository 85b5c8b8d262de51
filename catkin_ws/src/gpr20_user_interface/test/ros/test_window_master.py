#!/usr/bin/env python3
"""The window over the death of the ROS master: said plainly, and it comes back by itself."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from typing import Dict

import rosgraph
import rospy
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from waiting import LIMIT_S
from window_case import WindowCase, run_on_a_screen, wait_until

from gpr20_operator.robot.condition import JobLevel

# Long before any request to the robot has failed, on a computer that stalls.
WARNING_LIMIT_S = 1.5
HERE = os.path.dirname(os.path.abspath(__file__))


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


class OwnMaster:
    """A master that a test may kill, and what runs on it."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._processes: Dict[str, subprocess.Popen] = {}

    def start(self) -> None:
        """Start the master, unless it runs."""
        if "master" in self._processes:
            return
        command = ["rosmaster", "--core", "-p", str(self._port)]
        self._processes["master"] = subprocess.Popen(command)
        wait_until(rosgraph.is_master_online, "the master answers")

    def start_control(self) -> None:
        path = os.path.join(HERE, "fake_main_control_node.py")
        self._processes["control"] = subprocess.Popen([sys.executable, path])

    def kill(self, *names: str) -> None:
        for name in names or list(self._processes):
            process = self._processes.pop(name)
            process.kill()
            process.wait()


class WindowAndMaster(WindowCase):
    def setUp(self) -> None:
        master.start()
        self.addCleanup(master.kill)

    def test_stop_without_master_and_robot_says_at_once_to_switch_off_the_motors(self) -> None:
        master.start_control()
        rospy.wait_for_service("stop_survey", LIMIT_S)
        self.open_window()
        wait_until(lambda: self.title() == "IDLE", "the window has contact with main_control")
        self.click("start")
        wait_until(lambda: self.title() == "SURVEYING", "a survey starts")
        # The window knows of neither when STOP is pressed.
        master.kill()
        pressed_s = time.monotonic()
        QTest.mousePress(self.window.top_bar.stop, Qt.LeftButton)
        warning = self.window.stop_warning
        wait_until(warning.isVisible, "the warning is shown")
        self.assertLess(time.monotonic() - pressed_s, WARNING_LIMIT_S)
        QTest.mouseRelease(self.window.top_bar.stop, Qt.LeftButton)
        self.assertIn("MOTORS' POWER", warning.title.text())
        self.keep_picture("stop_without_master")
        # It stays when every time limit has run out.
        wait_until(lambda: "does NOT answer" in warning.text.whole, "the axes are named")
        self.assertTrue(warning.isVisible())
        self.touch(warning.close_button)
        self.assertTrue(warning.isVisible())

    def test_death_of_the_master_is_said_and_the_next_one_is_joined(self) -> None:
        master.start_control()
        # The window learns at its start where to stop the robot.
        rospy.wait_for_service("stop_survey", LIMIT_S)
        self.open_window()
        wait_until(lambda: self.title() == "IDLE", "the window has contact with main_control")
        self.enter("x_points", "7")
        self.click("start")
        wait_until(lambda: self.title() == "SURVEYING", "a survey starts")
        master.kill("master")
        band = self.window.top_bar.band
        wait_until(
            lambda: "ROS master does not answer" in band.message.whole, "the loss is reported"
        )
        self.assertEqual(band.level, JobLevel.FAULT)
        self.keep_picture("master_gone")
        self.click("stop")
        wait_until(lambda: self.title() == "STOPPED", "STOP needs no master")
        master.kill("control")
        master.start()
        master.start_control()
        # The old one has said STOPPED; without it the window soon says NO CONTACT, if it lasts.
        wait_until(lambda: self.title() == "IDLE", "the new main control is heard")
        wait_until(lambda: "NO CONTACT" not in band.title.whole, "the return is reported")
        wait_until(lambda: self.window.control.start.isEnabled(), "START is unlocked")
        self.assertEqual(self.window.control.parameters.x_points, 7)
        self.click("start")
        wait_until(lambda: self.title() == "SURVEYING", "a survey starts on the new master")
        self.click("stop")
        wait_until(lambda: self.title() == "STOPPED", "and stops")


if __name__ == "__main__":
    port = free_port()
    # Before anything asks for the master: this test has one of its own.
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    master = OwnMaster(port)
    master.start()
    run_on_a_screen("window_master", WindowAndMaster)
