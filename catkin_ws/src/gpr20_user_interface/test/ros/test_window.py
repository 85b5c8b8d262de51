#!/usr/bin/env python3
"""The real window on a real screen and a real ROS graph, with a fake main_control."""

from __future__ import annotations

import time
from typing import List

from fake_main_control import ANSWER_LIMIT_S, FakeMainControl
from PyQt5 import sip
from PyQt5.QtWidgets import QApplication
from window_case import WindowCase, new_interface, run_on_a_screen, wait_until

from gpr20_common.catalogue import Language
from gpr20_common.high.services import advertise
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_common.sent_message import message_fields
from gpr20_msgs.srv import Command, CommandResponse
from gpr20_operator.plan.spec import Tile
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.plan.annotation import Annotation, Wgs84Position


class Window(WindowCase):
    def setUp(self) -> None:
        self.fake = FakeMainControl("")
        self.addCleanup(lambda: self.fake.close())
        self.open_window()
        wait_until(lambda: self.title() == "IDLE", "the window has contact with main_control")
        wait_until(lambda: self.enabled() == "start", "START is unlocked")

    def start(self) -> None:
        self.enter("x_points", "3")
        self.enter("y_points", "3")
        self.fake.point_limit = 7
        self.click("start")
        wait_until(lambda: self.window.job.percent.text() == "38 %", "progress moves")
        # What other topics say may come later.
        wait_until(lambda: self.window.job.line.isVisible(), "the target is shown")
        known = self.window.survey
        wait_until(lambda: known.snapshot.current is not None, "the position is known")
        # The message has single precision.
        wait_until(lambda: round(known.snapshot.height_m or 0.0, 6) == 0.312, "the height is known")
        wait_until(lambda: self.title() == "SURVEYING", "the status is shown")

    def test_start_progress_stop(self) -> None:
        self.start()
        self.assertEqual(self.window.job.percent.text(), "38 %")
        self.assertEqual(self.window.job.left.text(), "Less than 1 min left")
        self.assertTrue(self.window.top_bar.band.simulated.isVisible())
        self.assertFalse(self.window.control.tiles[Tile.AREA].isEnabled())
        wait_until(lambda: self.enabled() == "pause", "PAUSE is unlocked")
        self.keep_picture("surveying")
        self.fake.may_stop.clear()
        self.click("stop")
        wait_until(lambda: self.title() == "STOPPING", "stop is asked for")
        # The axes still move: the window does not claim that they stopped (nor unlocks).
        self.assertEqual(self.enabled(), "")
        self.fake.may_stop.set()
        wait_until(lambda: self.title() == "STOPPED", "main_control says stopped")
        wait_until(lambda: self.enabled() == "start", "START is unlocked")
        self.assertFalse(self.window.notice.isVisible())

    def test_notes_written_with_a_finger_go_with_the_start(self) -> None:
        sheet = self.window.annotation
        self.touch_notes()
        for name, text in (("operator", "Lucía Peña"), ("position", "4.6,-74.1")):
            self.touch(sheet.tiles[name])
            sheet.pad.press(text)
            self.touch(sheet.pad.accept_button)
        self.keep_picture("notes")
        self.touch(sheet.save)
        self.start()
        expected = Annotation("Lucía Peña", position=Wgs84Position(4.6, -74.1))
        self.assertEqual(self.fake.annotation, expected)

    def test_paused_survey_is_resumed(self) -> None:
        self.start()
        self.fake.pause("the VNA does not answer")
        wait_until(lambda: self.enabled() == "resume", "RESUME is unlocked")
        self.assertIn("The VNA does not answer", self.window.top_bar.band.message.whole)
        self.fake.point_limit = 18
        self.click("resume")
        wait_until(lambda: self.title() == "FINISHED", "the survey continues")
        self.assertEqual(self.window.job.percent.text(), "100 %")

    def test_another_vna_is_used_only_if_the_operator_accepts_it(self) -> None:
        self.start()
        self.fake.pause("the VNA is another one")
        self.fake.other_analyzer = "Anritsu,MS2026C/2,62011033,1.23"
        question = self.window.question
        for button in (question.close_button, question.accept_button):
            wait_until(lambda: self.enabled() == "resume", "RESUME is unlocked")
            self.click("resume")
            wait_until(question.isVisible, "a question opens")
            self.keep_picture("other_vna")
            self.assertIn(self.fake.other_analyzer, question.details.toPlainText())
            self.fake.point_limit = 18
            self.touch(button)
        self.hold()
        wait_until(lambda: self.title() == "FINISHED", "the survey continues")
        self.assertEqual(self.fake.resumed_with, ["", "", self.fake.other_analyzer])

    def test_axis_limits_of_the_robot_lock_start(self) -> None:
        self.fake.describe_robot()
        self.enter("x_stop_mm", "700")
        wait_until(lambda: self.enabled() == "", "START is locked")
        self.assertIn("from 0 to 650", self.window.control.tiles[Tile.AREA].sentence.whole)
        self.enter("x_stop_mm", "650")
        wait_until(lambda: self.enabled() == "start", "START is unlocked")

    def test_refusal_opens_a_dialog_that_does_not_block(self) -> None:
        self.fake.refusal = Message("permission denied", details="errno 13")
        self.click("start")
        wait_until(self.window.notice.isVisible, "a dialog opens")
        self.assertEqual(self.window.notice.reason.toPlainText(), "Permission denied")
        self.assertIn("errno 13", self.window.notice.details.toPlainText().splitlines())
        self.languages.use(Language.SPANISH)
        spanish = "Permiso denegado"
        wait_until(
            lambda: self.window.notice.reason.toPlainText() == spanish,
            "it is translated",
        )
        self.languages.use(Language.ENGLISH)
        self.assertEqual(self.fake.starts, 0)
        self.keep_picture("refused")
        self.touch(self.window.notice.close_button)
        wait_until(lambda: self.enabled() == "start", "START can be tried again")

    def test_control_that_hangs_does_not_freeze_the_window(self) -> None:
        self.fake.may_answer.clear()
        self.click("start")
        wait_until(lambda: self.fake.asked > 0, "main_control is asked")
        self.assertEqual(self.enabled(), "")
        started_s = time.monotonic()
        QApplication.processEvents()
        # A window that waits for the answer waits for a minute.
        self.assertLess(time.monotonic() - started_s, ANSWER_LIMIT_S / 4)
        self.fake.may_answer.set()
        wait_until(lambda: self.fake.visited > 0, "the survey runs after all")

    def test_vanished_control_is_told_and_comes_back(self) -> None:
        self.start()
        self.fake.close()
        wait_until(
            lambda: "contact with the main control for" in self.window.top_bar.band.message.whole,
            "the loss is reported",
        )
        # What the robot does is not known: neither stopped nor free to start.
        self.assertEqual(self.title(), "SURVEYING")
        self.assertEqual(self.enabled(), "")
        self.keep_picture("control_gone")
        self.fake = FakeMainControl("")
        # The next main_control knows nothing of the survey: the window does not forget it.
        wait_until(
            lambda: "INTERRUPTED" in self.window.top_bar.band.title.whole, "the return is reported"
        )
        self.assertEqual(self.title(), "IDLE")
        self.touch(self.window.notice.close_button)
        wait_until(lambda: self.enabled() == "start", "START is unlocked")
        self.click("start")
        wait_until(
            lambda: "SURVEYING" in self.window.top_bar.band.title.whole, "a survey runs again"
        )

    def test_survey_of_somebody_else_is_shown(self) -> None:
        self.start()
        second = new_interface(SurveyModel(Clock()), self.languages)
        second.begin()
        self.addCleanup(lambda: sip.delete(second.window))
        self.addCleanup(second.end)
        wait_until(lambda: second.window.job.percent.text() == "38 %", "the second window follows")
        mine, other = self.window.control, second.window.control
        wait_until(lambda: not other.tiles[Tile.AREA].isEnabled(), "its parameters are locked")
        wait_until(lambda: other.parameters == mine.parameters, "it shows the parameters")
        self.assertTrue(second.window.top_bar.stop.isEnabled())
        self.assertEqual(other.parameters.x_points, 3)

    def test_survey_is_paused_on_request_and_resumed(self) -> None:
        self.fake.may_pause.clear()
        self.start()
        wait_until(lambda: self.enabled() == "pause", "PAUSE is unlocked")
        self.click("pause")
        wait_until(lambda: self.title() == "PAUSING", "the pause is asked for")
        self.assertEqual(self.enabled(), "")
        self.fake.may_pause.set()
        wait_until(lambda: self.enabled() == "resume", "RESUME is unlocked")
        self.fake.point_limit = 18
        self.click("resume")
        wait_until(lambda: self.title() == "FINISHED", "the survey continues")

    def test_a_pause_that_is_refused_opens_its_dialog(self) -> None:
        self.start()
        wait_until(lambda: self.enabled() == "pause", "PAUSE is unlocked")
        # Between what the window shows and the touch the survey ends.
        self.fake.end_silently()
        self.click("pause")
        wait_until(self.window.notice.isVisible, "a dialog opens")
        self.assertEqual(self.window.notice.title.text(), "The survey was not paused.")
        self.assertIn("No survey", self.window.notice.reason.toPlainText())
        self.assertTrue(self.window.notice.first.text())

    def test_a_stop_that_nobody_answers_says_so(self) -> None:
        self.start()
        self.fake.close()
        self.click("stop")
        warning = self.window.stop_warning
        wait_until(warning.isVisible, "over everything, until it is closed by a hold")
        self.assertIn("MOTORS' POWER", warning.title.text())
        wait_until(lambda: "main control does NOT" in warning.text.whole, "it is not there")
        for axis in "xyz":
            self.assertIn(f"{axis} axis does not answer", warning.text.whole.lower(), axis)

    def test_every_press_of_stop_reaches_the_axes_whatever_the_control_says(self) -> None:
        stopped = self.advertise_axes()
        warning = self.window.stop_warning
        self.start()
        self.press_stop(stopped)
        wait_until(lambda: self.title() == "STOPPED", "the survey ends")
        # No survey runs now, but a goal from a terminal may move an axis.
        self.press_stop(stopped)
        wait_until(lambda: "main control: no survey" in warning.text.whole, "it is refused")
        self.fake.close()
        self.press_stop(stopped)
        wait_until(lambda: "main control does NOT" in warning.text.whole, "it is not there")
        # An answer proves nothing: no axis has said that it rests.
        self.assertIn("x axis: stopping", warning.text.whole.lower())
        self.assertTrue(warning.isVisible())

    def press_stop(self, stopped: List[str]) -> None:
        stopped.clear()
        self.click("stop")
        wait_until(lambda: sorted(stopped) == ["x", "y", "z"], "every axis is asked")

    def advertise_axes(self) -> List[str]:
        """Advertise the services that stop the axes; return the axes that are stopped."""
        stopped: List[str] = []

        def stop(axis: str) -> CommandResponse:
            stopped.append(axis)
            return CommandResponse(success=True, **message_fields(verbatim("stopping")))

        for axis in "xyz":
            service = advertise(f"{axis}_axis/stop", Command, lambda _request, a=axis: stop(a))
            self.addCleanup(service.shutdown)
        return stopped

    def test_language_changes_at_once(self) -> None:
        self.start()
        sheet = self.window.settings
        self.touch(self.window.rail.settings)
        self.touch(sheet.languages[Language.SPANISH])
        wait_until(lambda: self.window.top_bar.pause.text() == "PAUSAR", "it speaks Spanish")
        self.assertEqual(sheet.title.text(), "Ajustes")
        self.touch(sheet.languages[Language.ENGLISH])
        wait_until(lambda: self.window.top_bar.pause.text() == "PAUSE", "it speaks English")


if __name__ == "__main__":
    run_on_a_screen("window", Window)
