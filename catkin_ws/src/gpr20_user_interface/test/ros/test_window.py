#!/usr/bin/env python3
"""The real window on a real screen and a real ROS graph, with a fake main_control."""

from __future__ import annotations

import os
import tempfile
import threading
import time
import unittest
from typing import Callable

import rospy
import rostest
import waiting
from fake_main_control import FakeMainControl
from PyQt5 import sip
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QMessageBox
from virtual_screen import VirtualScreen

from gpr20_common.low.clock import Clock
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.mid.survey_model import SurveyModel
from gpr20_user_interface.mid.survey_state import Event


def wait_until(condition: Callable[[], bool], what: str) -> None:
    waiting.wait_until(condition, what, pause=lambda: QTest.qWait(20))


class WatchedModel(SurveyModel):
    """Remembers which threads told it something."""

    def __init__(self, clock: Clock) -> None:
        super().__init__(clock)
        self.threads: set = set()

    def handle(self, event: Event) -> None:
        self.threads.add(threading.current_thread())
        super().handle(event)


class Window(unittest.TestCase):
    def setUp(self) -> None:
        self.fake = FakeMainControl("")
        self.addCleanup(lambda: self.fake.close())
        self.model = WatchedModel(Clock())
        self.interface = UserInterface(self.model)
        self.window = self.interface.window
        self.interface.begin()
        self.addCleanup(self.end_interface)
        wait_until(lambda: self.window.status.title == "IDLE", "the window hears main_control")

    def end_interface(self) -> None:
        # Widgets that other threads touch crash after tens of minutes.
        self.assertEqual(self.model.threads, {threading.main_thread()})
        self.interface.end()
        sip.delete(self.window)

    def enter(self, name: str, text: str) -> None:
        edit = self.window.form.edit(name)
        edit.selectAll()
        QTest.keyClicks(edit, text)

    def click(self, name: str) -> None:
        QTest.mouseClick(getattr(self.window.commands, name), Qt.LeftButton)

    def enabled(self) -> str:
        commands = self.window.commands
        names = ("start", "stop", "resume")
        return " ".join(name for name in names if getattr(commands, name).isEnabled())

    def start(self) -> None:
        self.enter("x_points", "3")
        self.enter("y_points", "3")
        self.fake.point_limit = 7
        self.click("start")
        wait_until(lambda: "7 of 18 traces" in self.window.progress.texts, "progress moves")

    def dialogs(self) -> list:
        return [box for box in self.window.findChildren(QMessageBox) if box.isVisible()]

    def test_start_progress_stop(self) -> None:
        self.assertEqual(self.enabled(), "start")
        self.start()
        self.assertEqual(self.window.progress.thousandths, 388)
        self.assertIn("0d:0h:0m:1s remaining", self.window.progress.texts)
        self.assertEqual(self.window.positions.cell("current", 1), "7.00")
        self.assertEqual(self.window.positions.cell("target", 2), "14.00")
        self.assertEqual(self.window.positions.cell("current", 4), "0.312")
        self.assertIn("SIMULATED", self.window.banners.texts)
        self.assertFalse(self.window.form.isEnabled())
        self.assertEqual(self.enabled(), "stop")
        self.keep_picture("surveying")
        self.fake.may_stop.clear()
        self.click("stop")
        wait_until(lambda: self.window.status.title == "STOPPING", "stop is asked for")
        # The axes still move: the window does not claim that they stopped (nor unlocks).
        self.assertEqual(self.enabled(), "stop")
        self.fake.may_stop.set()
        wait_until(lambda: self.window.status.title == "STOPPED", "main_control says stopped")
        wait_until(lambda: self.enabled() == "start", "START is unlocked")
        self.assertEqual(self.dialogs(), [])

    def test_paused_survey_is_resumed(self) -> None:
        self.start()
        self.fake.pause("the VNA does not answer")
        wait_until(lambda: self.enabled() == "stop resume", "RESUME is unlocked")
        self.assertEqual(self.window.status.message, "the VNA does not answer")
        self.fake.point_limit = 18
        self.click("resume")
        wait_until(lambda: self.window.status.title == "FINISHED", "the survey goes on")
        self.assertEqual(self.window.progress.thousandths, 1000)

    def test_axis_limits_of_the_robot_lock_start(self) -> None:
        self.fake.set_axis_parameters()
        self.interface.link.read_axis_limits()
        self.enter("x_stop_mm", "700")
        wait_until(lambda: self.enabled() == "", "START is locked")
        self.assertIn("between 0 and 650 mm", self.window.problems.toPlainText())
        self.enter("x_stop_mm", "650")
        wait_until(lambda: self.enabled() == "start", "START is unlocked")

    def test_refusal_opens_a_dialog_that_does_not_block(self) -> None:
        self.fake.refusal = "the VNA is not calibrated; calibrate it"
        self.click("start")
        wait_until(lambda: len(self.dialogs()) == 1, "a dialog opens")
        dialog = self.dialogs()[0]
        self.assertIn("not calibrated", dialog.informativeText())
        self.assertTrue(self.window.isEnabled())
        self.assertEqual(self.fake.starts, 0)
        self.keep_picture("refused", dialog)
        dialog.close()
        wait_until(lambda: self.enabled() == "start", "START can be tried again")

    def test_control_that_hangs_does_not_freeze_the_window(self) -> None:
        self.fake.may_answer.clear()
        self.click("start")
        wait_until(lambda: self.fake.asked > 0, "main_control is asked")
        self.assertEqual(self.enabled(), "stop")
        started_s = time.monotonic()
        QApplication.processEvents()
        self.assertLess(time.monotonic() - started_s, 1.0)
        self.fake.may_answer.set()
        wait_until(lambda: self.fake.visited > 0, "the survey runs after all")

    def test_vanished_control_is_told_and_comes_back(self) -> None:
        self.start()
        self.fake.close()
        wait_until(lambda: "not heard for" in self.window.banners.texts, "the loss is told")
        # What the robot does is not known: neither stopped nor free to start.
        self.assertEqual(self.window.status.title, "SURVEYING")
        self.assertEqual(self.enabled(), "stop")
        self.keep_picture("control_gone")
        self.fake = FakeMainControl("")
        wait_until(lambda: "not heard" not in self.window.banners.texts, "the return is told")
        wait_until(lambda: self.enabled() == "start", "START is unlocked")

    def test_survey_of_somebody_else_is_shown(self) -> None:
        self.start()
        second = UserInterface(SurveyModel(Clock()))
        second.begin()
        self.addCleanup(lambda: sip.delete(second.window))
        self.addCleanup(second.end)
        wait_until(lambda: "7 of 18" in second.window.progress.texts, "the second window follows")
        self.assertFalse(second.window.form.isEnabled())
        self.assertTrue(second.window.commands.stop.isEnabled())
        self.assertIn("not started here", second.window.problems.toPlainText())
        self.assertEqual(self.window.problems.toPlainText(), "")

    def keep_picture(self, name: str, widget: object = None) -> None:
        """Write what is on the screen where an engineer can look at it."""
        folder = os.environ.get("GPR20_PICTURES", "")
        if not folder:
            folder = tempfile.mkdtemp()
            self.addCleanup(lambda: os.rmdir(folder))
            self.addCleanup(lambda: os.remove(path))
        path = os.path.join(folder, f"{name}.png")
        picture = (widget or self.window).grab()
        self.assertEqual(picture.isNull(), False)
        self.assertTrue(picture.save(path))
        if widget is None:
            self.assertEqual((picture.width(), picture.height()), (800, 480))


if __name__ == "__main__":
    screen = VirtualScreen()
    os.environ["DISPLAY"] = screen.name
    os.environ["QT_QPA_PLATFORM"] = "xcb"
    application = QApplication([])
    rospy.init_node("test_window", disable_signals=True)
    try:
        rostest.rosrun("gpr20_user_interface", "window", Window)
    finally:
        rospy.signal_shutdown("the tests are over")
        # Qt lets go of the screen before the screen goes away.
        sip.delete(application)
        screen.close()
