#!/usr/bin/env python3
"""The walk of somebody who sees the window for the first time: start, where, report on a stick.

With real touches of an X server on the whole simulated robot, with the plan that the window
proposes, in one of its languages. `GPR20_PICTURES=FOLDER` keeps a picture of each stage.
"""

from __future__ import annotations

import os
import random
import re
import tempfile
import unittest
from pathlib import Path

import rospy
import rostest
from touched_window import TouchedWindow
from waiting import wait_until

from gpr20_common.catalogue import Language

SERVICES = ("list_volumes", "export_survey", "cancel_imaging", "imaging_progress")
SURVEY_LIMIT_S = 120.0
PLACE = re.compile(r"X (-?\d+)\D+(\d+)\D+Y (-?\d+)\D+(\d+)")


class Walk(unittest.TestCase):
    def walk(self, language: Language) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        beside = [f"{name}:=/with_stick/{name}" for name in SERVICES]
        window = TouchedWindow(Path(folder.name), arguments=["--language", language.value, *beside])
        self.addCleanup(window.close)
        stick = Path(rospy.get_param("~stick"))

        wait_until(lambda: window.takes_touches("control.start"), "there is contact")
        others = window.touches
        self.keep_picture(window, language, "plan")
        window.tap("control.start")
        self.keep_picture(window, language, "start")
        window.hold("start_sheet.hold")
        self.assertLessEqual(window.touches - others, 3)
        wait_until(lambda: window.is_shown("job"), "the survey runs")
        self.keep_picture(window, language, "survey")

        started, first = window.touches, "result.rows.0.place"
        wait_until(lambda: window.is_shown(first), "the places are shown", limit_s=SURVEY_LIMIT_S)
        self.keep_picture(window, language, "where")
        self.assertLessEqual(window.touches - started, 2)
        self.assertRegex(window.find(first)["text"], PLACE)

        known = window.touches
        window.tap("result.stick")
        try:
            wait_until(
                lambda: (
                    any(stick.rglob("*.pdf")) and not window.is_shown("result.stick_sheet.cancel")
                ),
                "the report is on the stick, and the window says so",
                limit_s=SURVEY_LIMIT_S,
            )
        finally:
            self.keep_picture(window, language, "stick")
        self.assertLessEqual(window.touches - known, 2)
        window.close()

    def keep_picture(self, window: TouchedWindow, language: Language, stage: str) -> None:
        folder = os.environ.get("GPR20_PICTURES", "")
        if folder:
            window.find(f"picture:{folder}/walk_{stage}_{language.value}.png")

    def test_a_survey_its_places_and_the_report_take_few_touches(self) -> None:
        language = random.choice([Language.ENGLISH, Language.SPANISH])
        rospy.loginfo("the window is in language %s", language.value)
        self.walk(language)


if __name__ == "__main__":
    rospy.init_node("test_walk", disable_signals=True)
    rostest.rosrun("gpr20_user_interface", "walk", Walk)
