#!/usr/bin/env python3
"""The computer's clock is set in the middle of a survey: nothing is lost, nothing stalls."""

import json
import os
import shutil
import sys
import time
import unittest
from pathlib import Path

import rospy
import rostest

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE
from gpr20_common.sent_message import received_message
from gpr20_msgs.msg import ControlStatus

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from survey_client import SurveyClient, json_traces

CLOCK_SET = "clock.set_during_survey"
HOUR_S = 3600
STALL_LIMIT_S = 20.0
TRACES = 50


class ClockSetTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("clock_set_rostest")
        cls.client = SurveyClient()
        cls.clock = Path(os.environ["GPR20_CLOCK_OFFSET"])
        cls.client.data.mkdir(parents=True, exist_ok=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(str(cls.client.data.parent))

    def setUp(self):
        self.set_clock(0)

    def set_clock(self, offset_s):
        temporary = self.clock.with_suffix(".new")
        temporary.write_text(str(offset_s))
        temporary.replace(self.clock)  # nobody reads half of it

    def begin(self):
        survey_id = self.client.begin(x_points=5, y_points=5)
        self.client.wait_for_visited(5)
        return survey_id

    def check_complete(self, survey_id):
        status = self.client.wait_for_status(ControlStatus.FINISHED, ControlStatus.PAUSED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        folder = self.client.folder(survey_id)
        found = verify_survey(folder)
        self.assertEqual((found.status, found.faults), (COMPLETE, []))
        for trace in json_traces(folder):
            self.assertLess(trace["sweep_started"], trace["sweep_ended"])
        return json_traces(folder)

    def check_said(self, survey_id, code, step_s=None):
        """Check that it is in the status from then on, in the report, and with one trace."""
        # From that moment on to the end.
        self.assertEqual(self.client.statuses[-1].fault_code, code)
        self.assertEqual(self.client.statuses[-1].code, ControlStatus.FINISHED)
        folder = self.client.folder(survey_id)
        report = json.loads((folder / "survey.json").read_text())["report"]
        (warning,) = report["warnings"]
        message = received_message("", json.dumps(warning["warning_message"]))
        self.assertEqual(message.fault_code, code)
        if step_s is not None:
            self.assertIn(str(step_s), str(message))
        remarked = [one for one in json_traces(folder) if str(message)[:60] in str(one["quality"])]
        # While the survey is paused, the status says it before the next trace is measured.
        self.assertLessEqual(len(remarked), 1)

    def check_clock_set_in_a_survey(self, offset_s):
        survey_id = self.begin()
        self.set_clock(offset_s)
        begun_s = time.monotonic()
        traces = self.check_complete(survey_id)
        self.assertLess(time.monotonic() - begun_s, STALL_LIMIT_S)
        self.check_said(survey_id, CLOCK_SET, abs(offset_s))
        return [trace["timestamp"] for trace in traces]

    def test_01_back_by_an_hour(self):
        times = self.check_clock_set_in_a_survey(-HOUR_S)
        # The traces tell the time of day as it was: what was measured last looks oldest.
        self.assertLess(times[-1], times[0])

    def test_02_forth_by_a_day(self):
        times = self.check_clock_set_in_a_survey(24 * HOUR_S)
        self.assertEqual(times, sorted(times))

    def test_03_back_between_a_stop_and_a_resumption(self):
        survey_id = self.begin()
        self.assertTrue(self.client.stop().success)
        self.client.wait_for_status(ControlStatus.STOPPED)
        self.set_clock(-24 * HOUR_S)
        self.client.go_on(self.client.folder(survey_id).name)
        self.check_complete(survey_id)
        report = json.loads((self.client.folder(survey_id) / "survey.json").read_text())["report"]
        # The known point, at both rotations.
        self.assertEqual(len(report["controls"]), 2)
        self.check_said(survey_id, "clock.behind_last_trace")

    def test_04_back_while_paused(self):
        survey_id = self.begin()
        self.assertTrue(self.client.pause().success)
        self.client.wait_for_status(ControlStatus.PAUSED)
        self.set_clock(-HOUR_S)
        self.client.wait(lambda: self.client.statuses[-1].fault_code == CLOCK_SET)
        self.client.go_on(survey_id)
        self.check_complete(survey_id)
        self.check_said(survey_id, CLOCK_SET, HOUR_S)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "clock_set", ClockSetTest)
