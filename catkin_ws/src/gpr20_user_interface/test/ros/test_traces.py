#!/usr/bin/env python3
"""GROUND and the past surveys with a real screen, the real storage and the real survey."""

from __future__ import annotations

import os
import shutil
import socket
import statistics
import time
import unittest
from typing import Any, Callable, Dict
from unittest import mock

import rospy
import rostest
import waiting
from PyQt5 import sip
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from virtual_screen import VirtualScreen
from window_case import new_interface

from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.high.raw_message import deserialized
from gpr20_common.low.clock import Clock
from gpr20_msgs.msg import ControlStatus, Trace
from gpr20_msgs.srv import Command, ReadTraces, ResumeSurvey, SetSurveyParameters, StartSurvey
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.shade_colours import NOT_MEASURED
from gpr20_operator.high.conversions import parameters_message
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.terminal.survey_arguments import parse_arguments
from gpr20_user_interface.window.rail import TabName

SERVICES = {
    "set_survey_parameters": SetSurveyParameters,
    "start_survey": StartSurvey,
    "pause_survey": Command,
    "resume_survey": ResumeSurvey,
    "stop_survey": Command,
    "read_traces": ReadTraces,
}
SHOWN_WITHIN_S = 1.0


def wait_until(condition: Callable[[], bool], what: str) -> None:
    waiting.wait_until(condition, what, pause=lambda: QTest.qWait(10))


class Window:
    """The whole window, on the tab that a test looks at."""

    def __init__(self, tab: TabName) -> None:
        self.languages = Languages(QApplication.instance(), Language.ENGLISH)
        self.interface = new_interface(SurveyModel(Clock()), self.languages)
        self.window = self.interface.window
        self.traces = self.window.traces
        self.window.show_tab(tab)
        self.interface.begin()

    def drawn(self) -> int:
        """Return how many stops of the shown polarization are drawn from above."""
        numbers = self.window.ground.view.pictures.above.numbers
        return 0 if numbers is None else int((numbers != NOT_MEASURED).sum())

    def done(self) -> int:
        """Return how many stops of the survey that is shown are done; -1: not known."""
        counts = self.window.ground.model.survey.map.counts()
        return -1 if counts is None else counts[StopState.DONE]

    def close(self) -> None:
        self.interface.end()
        self.languages.close()
        sip.delete(self.window)


class Traces(unittest.TestCase):
    """The tests run in the order of their names; the surveys stay between them."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.services: Dict[str, rospy.ServiceProxy] = {}
        for name, kind in SERVICES.items():
            rospy.wait_for_service(name, waiting.LIMIT_S)
            cls.services[name] = rospy.ServiceProxy(name, kind)

    @classmethod
    def tearDownClass(cls) -> None:
        shutil.rmtree(rospy.get_param("~data"))

    def setUp(self) -> None:
        self.code = -1
        self.heard_s: Dict[int, float] = {}
        warnings = mock.patch.object(rospy, "logwarn")
        self.warned = warnings.start()
        self.addCleanup(warnings.stop)
        self.subscribers = [
            rospy.Subscriber("control_status", ControlStatus, self.note_status),
            rospy.Subscriber("trace", rospy.AnyMsg, self.note_trace),
        ]
        self.windows: list = []
        waiting.wait_until(
            lambda: all(one.get_num_connections() for one in self.subscribers), "all is received"
        )

    def tearDown(self) -> None:
        for subscriber in self.subscribers:
            subscriber.unregister()
        for window in self.windows:
            window.close()

    def note_status(self, message: ControlStatus) -> None:
        self.code = message.code

    def note_trace(self, message: rospy.AnyMsg) -> None:
        # As the window receives it: the subscriptions of one process are of one type.
        self.heard_s[deserialized(Trace, message._buff).index] = time.monotonic()

    def window(self, tab: TabName) -> Window:
        self.windows.append(Window(tab))
        return self.windows[-1]

    def call(self, name: str, *arguments: object, **fields: object) -> Any:
        answer = self.services[name](*arguments, **fields)
        self.assertTrue(answer.success, answer.message)
        return answer

    def start(self, points: int) -> None:
        stop_mm = str(100 + 10 * (points - 1))
        texts = ["--x-start", "100", "--x-stop", stop_mm, "--x-points", str(points)]
        texts += ["--y-start", "100", "--y-stop", "120", "--y-points", "3"]
        arguments = parse_arguments([*texts, "--frequency-points", "201"], Catalogue())
        plan = self.call("set_survey_parameters", parameters_message(arguments.parameters))
        self.call("start_survey", plan_id=plan.plan_id)

    def test_1_each_trace_is_seen_within_a_second(self) -> None:
        window = self.window(TabName.GROUND)
        self.start(4)
        radar = window.traces.live.radar
        seen_s: Dict[int, float] = {}
        drawn = 0

        def all_drawn() -> bool:
            nonlocal drawn
            if window.drawn() > drawn:
                drawn = window.drawn()
                seen_s[drawn] = time.monotonic()
            return drawn == 12

        wait_until(all_drawn, "the picture is full")
        # Of polarization 0, in the order of the plan: 0, 3, 4, 7, ...
        order = [4 * (number // 2) + (3 if number % 2 else 0) for number in range(12)]
        delays_s = [seen_s[number] - self.heard_s[order[number - 1]] for number in sorted(seen_s)]
        print(f"from the topic to the screen: at most {max(delays_s):.3f} s")
        # The median, as the computer may stall now and then.
        self.assertLess(statistics.median(delays_s), SHOWN_WITHIN_S)
        self.assertLess(max(delays_s), 10.0 * SHOWN_WITHIN_S)
        wait_until(lambda: radar.count == 24, "both polarizations are there")
        wait_until(lambda: self.code == ControlStatus.FINISHED, "the survey has ended")
        self.assertIn("SIMULATED", window.window.ground.view.note.text())
        wait_until(lambda: window.done() == 12, "the coverage is full")
        self.warned.assert_not_called()

    def test_2_a_window_that_is_started_in_the_middle_shows_what_was_measured_before(self) -> None:
        self.start(12)
        wait_until(lambda: len(self.heard_s) >= 20, "a good part is measured")
        window = self.window(TabName.GROUND)
        self.call("pause_survey")
        wait_until(lambda: self.code == ControlStatus.PAUSED, "the survey pauses")
        live = window.traces.live
        radar = live.radar

        def shows_everything() -> bool:
            # The last traces are stored and published while the survey pauses already.
            counts = live.map.counts()
            on_map = -1 if counts is None else 2 * counts[StopState.DONE] + counts[StopState.PARTLY]
            return radar.count == on_map == len(self.heard_s)

        wait_until(shows_everything, "the traces from before are there")
        self.assertLess(radar.count, 72)
        self.call("resume_survey", "", "", False)
        wait_until(lambda: radar.count == 72, "the rest comes, too")
        wait_until(lambda: self.code == ControlStatus.FINISHED, "the survey has ended")
        self.warned.assert_not_called()

    def test_3_an_unfinished_survey_is_listed_resumed_and_then_complete(self) -> None:
        self.start(6)
        wait_until(lambda: len(self.heard_s) >= 6, "some of it is measured")
        self.call("stop_survey")
        wait_until(lambda: self.code == ControlStatus.STOPPED, "the survey has stopped")
        window = self.window(TabName.SURVEYS)
        past = window.window.past
        stored = window.traces.past
        wait_until(lambda: len(stored.surveys) == 3, "the surveys are listed")
        self.assertEqual([one.complete for one in stored.surveys], [False, True, True])
        past.choose(stored.surveys[0])
        QTest.mouseClick(past.resume, Qt.LeftButton)
        self.hold(window)
        wait_until(lambda: self.code == ControlStatus.FINISHED, "it was resumed to its end")
        # The list is read again when a survey ends.
        wait_until(lambda: stored.surveys[0].complete, "it is complete")

    def hold(self, window: Window) -> None:
        """Hold the button of the summary, until what it says is requested."""
        hold = window.window.start_sheet.hold
        QTest.mousePress(hold, Qt.LeftButton)
        wait_until(lambda: not hold.isVisible(), "the button is held")
        QTest.mouseRelease(hold, Qt.LeftButton)

    def test_4_a_past_survey_is_opened(self) -> None:
        window = self.window(TabName.SURVEYS)
        past = window.window.past
        stored = window.traces.past
        wait_until(lambda: len(stored.surveys) == 3, "the surveys are listed")
        past.choose(stored.surveys[2])
        QTest.mouseClick(past.open, Qt.LeftButton)
        wait_until(lambda: window.traces.shown.radar.count == 24, "its traces are read")
        wait_until(lambda: window.drawn() == 12, "they are drawn")
        band = window.window.ground.view.band
        self.assertTrue(band.isVisible())
        self.assertIn("PAST SURVEY", band.whole)
        # Another client begins a survey: it takes the place of the past one.
        self.start(4)
        wait_until(lambda: not band.isVisible(), "the band is gone")
        self.assertNotEqual(window.done(), 12)
        wait_until(lambda: self.code == ControlStatus.FINISHED, "the survey has ended")
        wait_until(lambda: window.done() == 12, "the coverage is that of the new survey")
        self.warned.assert_not_called()

    def test_4b_its_focused_image_comes_from_the_node_beside_the_data(self) -> None:
        window = self.window(TabName.GROUND)
        export = window.window.result.result.export
        model = window.window.ground.model
        wait_until(lambda: window.traces.shown.radar.count == 24, "the last survey is shown")
        wait_until(lambda: model.image is not None, "its image is there")
        assert model.image is not None
        self.assertEqual(model.image.levels_db.shape[1:], (3, 4))
        self.assertEqual((model.image.traces, model.image.found.simulated), (24, True))
        export.look_for_sticks()
        name = socket.gethostname()
        wait_until(lambda: export.sticks.computer == name, "the node lists the sticks")

    def test_5_what_names_no_survey_is_refused(self) -> None:
        for name in ("", "../..", "/etc/passwd", "20260921T141320_0f8fad5b"):
            answer = self.services["read_traces"](name, [0])
            self.assertFalse(answer.success)
            self.assertTrue(answer.message)

    def test_6_what_is_no_trace_is_told_and_the_window_lives(self) -> None:
        window = self.window(TabName.GROUND)
        as_storage = {"callerid": "/vna_processing"}
        publisher = rospy.Publisher("trace", Trace, queue_size=1, headers=as_storage)
        self.addCleanup(publisher.unregister)

        def is_reported() -> bool:
            # Other nodes listen too: who is connected already need not be the window.
            publisher.publish(Trace(survey_id="none"))
            return bool(self.warned.called)

        wait_until(is_reported, "it is reported")
        self.assertIn("the trace is refused", str(self.warned.call_args[0][1]))
        self.assertEqual(window.traces.live.radar.given_up, {})

    def test_7_a_marked_place_is_measured_finer_and_both_surveys_know_each_other(self) -> None:
        window = self.window(TabName.GROUND)
        page, additions = window.window.ground, window.window.additions
        self.start(4)
        wait_until(lambda: self.code == ControlStatus.SURVEYING, "the survey is measuring")
        survey = window.window.survey
        wait_until(
            lambda: window.traces.shown.survey_id == survey.snapshot.running_survey != "",
            "its plan is here",
        )
        wait_until(lambda: additions.survey_id == window.traces.shown.survey_id, "it is followed")
        page.show_place(120.0, 110.0)
        QTest.mouseClick(page.view.set_marker, Qt.LeftButton)
        pad = page.note_pad
        pad.press("metal")
        pad.accept_button.click()
        wait_until(lambda: len(additions.markers) == 1, "the storage has the marker")
        other = self.window(TabName.GROUND)
        wait_until(lambda: other.window.additions.markers == additions.markers, "others see it")
        wait_until(lambda: self.code == ControlStatus.FINISHED, "the survey has ended")
        coarse = window.traces.shown.survey_id

        finer = page.finer
        wait_until(lambda: not window.window.survey.snapshot.running, "the window knows that")
        page.show_place(120.0, 110.0)
        QTest.mouseClick(page.view.finer, Qt.LeftButton)
        for _ in range(20):
            QTest.mouseClick(finer.wider, Qt.LeftButton)
        QTest.mouseClick(finer.use, Qt.LeftButton)
        self.assertEqual(self.code, ControlStatus.FINISHED)
        self.assertEqual(window.window.control.parameters.frequency_points, 201)
        wait_until(window.window.control.start.isEnabled, "START can be pressed")
        QTest.mouseClick(window.window.control.start, Qt.LeftButton)
        self.hold(window)
        wait_until(lambda: window.traces.shown.survey_id not in ("", coarse), "it has begun")
        wait_until(lambda: self.code == ControlStatus.FINISHED, "the finer survey has ended")

        def related() -> list:
            return [(one.survey_id, one.is_finer) for one in additions.related]

        wait_until(lambda: related() == [(coarse, False)], "it knows what it refines")
        fine = window.traces.shown.survey_id
        window.traces.open_survey(coarse)
        wait_until(lambda: related() == [(fine, True)], "the coarse one knows the finer one")
        self.assertEqual([one.text for one in additions.markers], ["metal"])


if __name__ == "__main__":
    screen = VirtualScreen()
    os.environ["DISPLAY"] = screen.name
    os.environ["QT_QPA_PLATFORM"] = "xcb"
    application = QApplication([])
    rospy.init_node("test_traces", disable_signals=True)
    try:
        rostest.rosrun("gpr20_user_interface", "traces", Traces)
    finally:
        rospy.signal_shutdown("the tests are over")
        # Qt lets go of the screen before the screen goes away.
        sip.delete(application)
        screen.close()
