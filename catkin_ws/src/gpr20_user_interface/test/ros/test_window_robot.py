#!/usr/bin/env python3
"""The real window on the whole simulated robot: a survey with a finger."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, Dict, List

import rospy
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from waiting import LIMIT_S
from window_case import WindowCase, run_on_a_screen, wait_until

from gpr20_common.high.service_client import ServiceClient
from gpr20_doctor.mid.node_health import HealthLevel
from gpr20_operator.high.conversions import parameters_message
from gpr20_operator.plan.spec import Tile
from gpr20_simulator.srv import SetFault
from gpr20_survey.axes.axis_id import AxisId
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.keys import DOWN, STEP
from gpr20_user_interface.window.rail import TabName


class WindowOnRobot(WindowCase):
    def setUp(self) -> None:
        self.open_window()
        wait_until(lambda: self.title() != "—", "the window has contact with main_control")
        wait_until(self.knows_the_robot, "the window knows the limits and the health of the robot")

    def knows_the_robot(self) -> bool:
        snapshot = self.window.survey.snapshot
        storage = snapshot.health.node("vna_processing")
        known = snapshot.figures is not None and storage.level is not HealthLevel.STALE
        return known and "start" in self.enabled()

    def visited(self) -> int:
        progress = self.window.survey.snapshot.progress
        return 0 if progress is None else progress.visited_points

    def arrow(self, name: str, direction: str, times: int) -> None:
        self.open_field(name)
        for _ in range(times):
            self.window.values.keys.press(direction)
        self.close_sheet()

    def enter_with_arrows(self) -> None:
        """3 x 3 stops on 50..130 mm, 51 frequencies."""
        control = self.window.control
        self.arrow("x_points", DOWN, 8)
        self.arrow("y_points", DOWN, 8)
        self.arrow("x_stop_mm", STEP, 1)
        self.arrow("x_stop_mm", DOWN, 2)
        self.arrow("y_stop_mm", DOWN, 2)
        self.arrow("frequency_points", STEP, 1)
        self.arrow("frequency_points", DOWN, 4)
        self.arrow("frequency_points", STEP, 2)
        self.arrow("frequency_points", DOWN, 5)
        parameters = control.parameters
        self.assertEqual((parameters.x_points, parameters.y_points), (3, 3))
        self.assertEqual((parameters.x_stop_mm, parameters.frequency_points), (130.0, 51))

    def test_survey_is_entered_started_paused_resumed_and_finished_with_a_finger(self) -> None:
        self.enter_with_arrows()
        start = self.window.control.start.lines[0]
        wait_until(lambda: "min" in start.whole, "time is estimated")
        self.assertTrue(start.whole.startswith("18 traces, "), start.whole)
        self.keep_picture("robot_control")
        self.click("start")
        wait_until(lambda: self.title() == "SURVEYING", "the survey runs")
        self.assertTrue(self.window.top_bar.band.simulated.isVisible())
        self.assertFalse(self.window.control.tiles[Tile.AREA].isEnabled())
        wait_until(lambda: 2 <= self.visited() < 18, "completion moves")
        self.click("pause")
        wait_until(lambda: self.title() == "PAUSED", "the survey pauses")
        held = self.visited()
        self.assertLess(held, 18)
        self.window.show_tab(TabName.ROBOT)
        survey = self.window.survey
        analyzer = lambda: survey.snapshot.health.node("vna_acquisition")  # noqa: E731
        wait_until(lambda: analyzer().reported.calibration != "", "calibration is known")
        self.keep_picture("robot_status")
        self.click("resume")
        wait_until(lambda: self.visited() > held, "completion moves again")
        wait_until(lambda: self.title() == "FINISHED", "the survey ends")
        self.assertEqual(self.window.job.percent.text(), "100 %")
        self.assertTrue(self.window.control.start.isEnabled())
        self.assertFalse(self.window.notice.isVisible())

    def annotation(self) -> Dict[str, Any]:
        """Return what is stored of the survey that is shown."""
        survey_id = self.window.survey.snapshot.state.survey_id
        (folder,) = Path(rospy.get_param("~data")).glob(f"*_{survey_id[:8]}")
        return json.loads((folder / "survey.json").read_text("ascii"))["annotation"]

    def write_note(self, name: str, text: str) -> None:
        """Add text to a field of the open sheet, and save it."""
        sheet = self.window.annotation
        wait_until(sheet.isVisible, "the sheet opens")
        sheet.tiles[name].click()
        sheet.pad.press(text)
        self.touch(sheet.pad.accept_button)
        self.touch(sheet.save)
        confirm = self.window.annotation.confirm
        if confirm.isVisible():
            self.hold(confirm)
        wait_until(lambda: not sheet.isVisible(), "the storage has the notes")

    def test_notes_are_written_before_during_and_after_a_survey(self) -> None:
        self.enter_with_arrows()
        self.touch_notes()
        self.write_note("operator", "Ana Peña")
        self.click("start")
        wait_until(lambda: self.title() == "SURVEYING", "the survey runs")
        wait_until(lambda: 2 <= self.visited() < 18, "completion moves")
        self.assertEqual(self.annotation()["operator"], "Ana Peña")
        self.touch(self.window.job.notes)
        self.write_note("notes", "wet")
        self.assertEqual(self.annotation()["notes"], "wet")
        wait_until(lambda: self.title() == "FINISHED", "the survey ends")
        self.window.show_tab(TabName.SURVEYS)
        past = self.window.past
        wait_until(lambda: any(one.complete for one in past.model.surveys[:1]), "it is listed")
        past.choose(past.model.surveys[0])
        self.touch(past.notes)
        self.write_note("notes", ", then dry")
        found = self.annotation()
        self.assertEqual((found["operator"], found["notes"]), ("Ana Peña", "wet, then dry"))
        self.assertFalse(self.window.notice.isVisible())

    def test_stop_works_from_every_tab_and_stopped_is_said_when_it_is(self) -> None:
        for tab in (TabName.ROBOT, TabName.SURVEY):
            self.window.show_tab(TabName.SURVEY)
            self.click("start")
            wait_until(lambda: self.title() == "SURVEYING", "the survey runs")
            self.window.show_tab(tab)
            self.click("stop")
            wait_until(lambda: self.title() == "STOPPED", "the robot has stopped")
            health = self.window.survey.snapshot.health
            axes = [health.node(f"{axis}_axis/axis_driver") for axis in "xyz"]
            wait_until(lambda: "start" in self.enabled(), "START is unlocked")
            self.assertTrue(all(axis is not None for axis in axes))

    def test_window_that_is_killed_and_started_again_shows_the_survey_that_runs(self) -> None:
        for name in ("x_points", "y_points"):
            self.enter(name, "21")
        self.click("start")
        wait_until(lambda: self.title() == "SURVEYING", "the survey runs")
        entered = str(parameters_message(self.window.control.parameters))
        # From here on no window is open but those of the processes.
        self.end_interface_early()
        first = WindowProcess()
        self.addCleanup(first.kill)
        wait_until(lambda: first.shown()["on_radar"] >= 2, "the first process shows traces")
        seen = first.shown()["visited"]
        self.assertEqual(first.kill(), -signal.SIGKILL)
        second = WindowProcess()
        self.addCleanup(second.kill)
        wait_until(lambda: second.shown()["visited"] > seen, "the survey went on without a window")
        wait_until(lambda: second.shown()["parameters"] == entered, "it shows the parameters")
        now = second.shown()
        self.assertEqual((now["title"], now["locked"], now["simulated"]), ("SURVEYING", True, True))
        # From the second window on traces come by the topic; those before are read back.
        second.shown("stop")
        wait_until(lambda: second.shown()["title"] == "STOPPED", "the new window stops the survey")
        wait_until(lambda: all_are_seen(second.shown()), "all traces so far are on MAP and RADAR")
        self.assertLess(second.shown()["visited"], 882)

    def test_vna_that_is_gone_is_said_and_the_survey_goes_on_when_it_is_back(self) -> None:
        set_fault = ServiceClient("simulator/set_fault", SetFault)
        self.addCleanup(lambda: set_fault.call(LIMIT_S, device="vna", fault="NONE", count=0))
        self.enter_with_arrows()
        self.click("start")
        wait_until(lambda: self.title() == "SURVEYING", "the survey runs")
        wait_until(lambda: 2 <= self.visited() < 18, "completion moves")
        set_fault.call(LIMIT_S, device="vna", fault="DROP", count=0)
        wait_until(self.has_vna_alarm, "the loss is reported")
        wait_until(lambda: self.title() == "PAUSED", "the survey holds")
        notice = self.window.notice
        wait_until(notice.isVisible, "the card of the fault opens")
        self.assertIn("Check that the VNA is switched on", notice.first.text())
        self.assertTrue(notice.resume.isVisible())
        self.assertIn("VNA", self.window.top_bar.band.message.whole)
        self.keep_picture("robot_vna_gone")
        set_fault.call(LIMIT_S, device="vna", fault="NONE", count=0)
        # The alarm ends with its cause, though the survey is still paused.
        wait_until(lambda: not self.has_vna_alarm(), "the return is reported")
        self.assertEqual(self.title(), "PAUSED")
        wait_until(lambda: "resume" in self.enabled(), "RESUME is unlocked")
        self.touch(notice.resume)
        # It asks, as RESUME beside STOP does.
        wait_until(self.window.start_sheet.isVisible, "a sheet asks")
        self.hold()
        wait_until(lambda: self.title() == "FINISHED", "the survey is finished after all")
        self.assertFalse(notice.isVisible())
        self.assertEqual(self.visited(), 18)

    def has_vna_alarm(self) -> bool:
        return self.window.survey.snapshot.health.trouble is not None

    def test_axes_and_instruments_are_serviced_with_a_finger(self) -> None:
        self.window.show_tab(TabName.ROBOT)
        page, view = self.window.robot, self.window.robot.service
        overview, tools = page.overview, view.instruments
        wait_until(lambda: "checks good" in overview.fold_button.text(), "the checks have ended")
        self.touch(overview.fold_button)
        wait_until(lambda: bool(overview.listed), "the findings are listed")
        self.assertTrue(any("simulated" in str(one.text) for one in overview.listed))
        self.keep_picture("robot_service")
        self.hold_down(overview.enter_button)
        wait_until(lambda: page.in_service, "the service begins")
        row = view.axes.row(AxisId.X)
        wait_until(lambda: "open" in row.lamp.text(), "the endstop is read")
        self.hold_down(row.home)
        wait_until(lambda: "closed" in row.lamp.text(), "the endstop is touched")
        wait_until(lambda: view.outcome.text() == "The x axis is homed.", "it is homed")
        wait_until(lambda: row.place.text() == "X 0.00 mm", "it is at its zero")
        self.hold_down(row.jogs[4])
        wait_until(lambda: row.place.text() == "X 10.00 mm", "it moves by 10 mm")
        wait_until(row.home.isEnabled, "the move has ended")
        self.keep_picture("robot_service_axes")
        self.hold_down(row.jogs[5])
        self.assertFalse(row.home.isEnabled())
        self.click("stop")
        wait_until(lambda: "stopped; the x axis" in view.outcome.text(), "STOP ends the jog")
        self.assertFalse(self.window.notice.isVisible())
        self.touch(view.switch_button)
        self.touch(tools.measure)
        wait_until(
            lambda: " V" in tools.answers[tools.measure].toPlainText(), "the height is measured"
        )
        self.touch(tools.analyzer)
        wait_until(
            lambda: "Sweep of" in tools.answers[tools.analyzer].toPlainText(), "the VNA is tested"
        )
        self.assertIn("SIMULATED", tools.answers[tools.analyzer].toPlainText())
        self.window.show_tab(TabName.SURVEY)
        wait_until(lambda: not page.in_service, "another tab ends the service")

    def hold_down(self, button: HoldButton) -> None:
        """Rest a finger on a button until it acts."""
        acted: List[bool] = []
        button.held.connect(lambda: acted.append(True))
        QTest.mousePress(button, Qt.LeftButton)
        wait_until(lambda: bool(acted), "the button is held")
        QTest.mouseRelease(button, Qt.LeftButton)

    def end_interface_early(self) -> None:
        # What closes a window at the end of the test must do so only once.
        self.doCleanups()


class WindowProcess:
    """The window in a process of its own; what it shows can be asked for."""

    def __init__(self) -> None:
        folder = os.path.dirname(os.path.abspath(__file__))
        self._process = subprocess.Popen(
            [sys.executable, os.path.join(folder, "window_process.py")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            universal_newlines=True,
        )

    def shown(self, line: str = "") -> Dict[str, Any]:
        """Return what it shows, after it has done what the line says."""
        assert self._process.stdin is not None and self._process.stdout is not None
        print(line, file=self._process.stdin, flush=True)
        return json.loads(self._process.stdout.readline())

    def kill(self) -> int:
        """End it as a crash does; return how it ended."""
        self._process.kill()
        self._process.communicate()
        return self._process.returncode


def all_are_seen(shown: Dict[str, Any]) -> bool:
    """Return whether every visited trace is on the map and in the radar pictures."""
    return shown["visited"] == shown["on_map"] == shown["on_radar"] > 0


if __name__ == "__main__":
    run_on_a_screen("window_robot", WindowOnRobot)
