#!/usr/bin/env python3
"""STOP of the window reaches the motors whoever moves them, also when main_control is frozen."""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from typing import Callable, Iterable

import actionlib
import rospkg
import rospy
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from waiting import LIMIT_S
from window_case import WindowCase, run_on_a_screen, wait_until

from gpr20_common.high.service_client import ServiceClient
from gpr20_msgs.msg import AxisAction, AxisGoal
from gpr20_msgs.srv import Command
from gpr20_operator.robot.condition import JobLevel
from gpr20_survey.axes.axis_id import AxisId
from gpr20_user_interface.window.rail import TabName

sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import node_pid

# From the press to an axis that says that it rests; a window that waited for main_control first
# took more than its time limit of 2 s.
REST_LIMIT_S = 1.5
FAR_MM = 640.0
SURVEYS = 6


class Stop(WindowCase):
    def setUp(self) -> None:
        self.open_window()
        wait_until(lambda: "start" in self.enabled(), "the robot is ready")
        wait_until(lambda: len(self.shown.axes) == len(AxisId), "every axis reports")

    @property
    def shown(self):
        return self.window.survey.snapshot

    def moves(self, axis: AxisId) -> bool:
        return any(one.axis is axis for one in self.shown.moving)

    def home(self, axes: Iterable[AxisId]) -> None:
        for axis in axes:
            answer = ServiceClient(f"{axis.value}_axis/homing", Command).call(LIMIT_S)
            self.assertTrue(answer.success, answer.message)

    def send_goal(self, axis: AxisId, target_mm: float) -> None:
        """Move an axis as a person at a terminal does, and wait until the window shows it."""
        client = actionlib.SimpleActionClient(f"{axis.value}_axis/axis", AxisAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(LIMIT_S)))
        client.send_goal(AxisGoal(target_coordinate=target_mm))
        wait_until(lambda: self.moves(axis), "the axis moves")
        wait_until(lambda: self.window.top_bar.band.title.whole == "ROBOT MOVES", "it is shown")

    def freeze_control(self) -> Callable[[], None]:
        """Freeze main_control until the test ends; return what wakes it."""
        pid = node_pid("/main_control")
        os.kill(pid, signal.SIGSTOP)

        def wake() -> None:
            os.kill(pid, signal.SIGCONT)

        self.addCleanup(wake)
        return wake

    def press_stop(self) -> float:
        """Press STOP; return how long it took until no axis reports that it moves [s]."""
        pressed_s = time.monotonic()
        QTest.mousePress(self.window.top_bar.stop, Qt.LeftButton)
        wait_until(lambda: not self.shown.moving, "every axis rests")
        elapsed_s = time.monotonic() - pressed_s
        QTest.mouseRelease(self.window.top_bar.stop, Qt.LeftButton)
        print(f"STOP: every axis at rest after {elapsed_s:.2f} s", flush=True)
        return elapsed_s

    def test_a_foreign_goal_is_seen_and_stopped_from_every_tab(self) -> None:
        self.home([AxisId.X])
        for tab in TabName:
            self.window.show_tab(tab)
            self.send_goal(AxisId.X, FAR_MM)
            self.assertEqual(self.window.top_bar.band.level, JobLevel.ATTENTION)
            self.assertTrue(self.window.top_bar.band.message.whole.startswith("X axis"))
            self.assertLess(self.press_stop(), REST_LIMIT_S)
            wait_until(self.window.notice.isVisible, "the answers are shown")
            self.assertEqual(self.window.notice.title.text(), "Every axis rests.")
            self.window.notice.hide()

    def test_a_foreign_goal_is_stopped_although_main_control_is_frozen(self) -> None:
        self.home([AxisId.X, AxisId.Y])
        self.send_goal(AxisId.Y, FAR_MM)
        wake = self.freeze_control()
        self.assertLess(self.press_stop(), REST_LIMIT_S)
        notice = self.window.notice
        wait_until(notice.isVisible, "the answers are shown")
        self.assertIn("The main control does not answer", notice.title.text())
        self.assertIn("main control does NOT answer", notice.reason.toPlainText())
        self.assertFalse(self.window.stop_warning.isVisible())
        wait_until(lambda: not self.shown.control_alive, "the silence is noticed")
        self.send_goal(AxisId.X, FAR_MM)
        self.assertEqual(self.window.top_bar.band.level, JobLevel.FAULT)
        self.assertLess(self.press_stop(), REST_LIMIT_S)
        wake()
        wait_until(lambda: self.shown.control_alive, "it is back")

    def test_a_survey_that_is_stopped_at_any_moment_was_stopped_on_request(self) -> None:
        moments = random.Random(1)
        for number in range(SURVEYS):
            self.click("start")
            wait_until(lambda: bool(self.shown.moving), "the robot moves")
            QTest.qWait(moments.randrange(1500))
            frozen = number % 3 == 2
            wake = self.freeze_control() if frozen else None
            self.assertLess(self.press_stop(), REST_LIMIT_S)
            if wake is not None:
                wake()
            wait_until(lambda: self.title() == "STOPPED", "the survey ends")
            code = self.shown.state.message.fault_code
            self.assertEqual(code, "survey.stopped_on_request", number)
            self.window.notice.hide()
            wait_until(lambda: not self.shown.pending, "STOP is answered")


if __name__ == "__main__":
    run_on_a_screen("stop", Stop)
