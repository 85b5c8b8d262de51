#!/usr/bin/env python3
"""A plug of the antennas that comes loose during a survey, and the check that finds it later."""

import json
import os
import shutil
import subprocess
import sys
import unittest

import rospkg
import rospy
import rostest

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE
from gpr20_msgs.msg import ControlStatus

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import SurveyClient, json_traces

TRACES = 18
STOP = 2  # traces
CHECK_LIMIT_S = 90.0


class DriftTest(unittest.TestCase):
    """The tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("drift_rostest")
        cls.client = SurveyClient()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def tearDown(self):
        self.client.set_fault(device="vna", fault="none")

    def test_1_a_plug_that_comes_loose_pauses_the_survey(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(STOP)
        self.client.set_fault(device="vna", fault="LOOSE_PLUG")
        paused = self.client.wait_for_status(ControlStatus.PAUSED, ControlStatus.FINISHED)
        self.assertEqual(paused.fault_code, "survey.drifted", paused.message)
        self.assertIn("drifted by 3.10 dB and 20.0 deg", paused.message)
        answer = self.client.resume(survey="")
        self.assertTrue(answer.success, answer.message)
        status = self.client.wait_for_status(ControlStatus.FINISHED, ControlStatus.FAILED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        folder = self.client.folder(survey_id)
        self.assertEqual([one["index"] for one in json_traces(folder)], list(range(TRACES)))
        self.assertEqual(verify_survey(folder).status, COMPLETE)
        visits = json.loads((folder / "survey.json").read_text())["report"]["drift"]["visits"]
        flags = [(one["exceeded"], one["accepted"]) for one in visits]
        begun = flags.index((True, False))
        self.assertEqual(flags[begun + 1], (False, True))
        self.assertEqual(set(flags[:begun] + flags[begun + 2 :]), {(False, False)})
        self.assertEqual(visits[-1]["next_index"], TRACES)
        for turn in visits[-1]["rotations"]:
            self.assertAlmostEqual(turn["gain_db"], -3.1, delta=0.1)

    def test_2_the_daily_check_says_that_a_simulated_robot_sees_no_plate(self):
        program = ["rosrun", "gpr20_main_control", "daily_check", "--language", "en"]
        made = subprocess.run(
            program, input="\n\n\n", capture_output=True, text=True, timeout=CHECK_LIMIT_S
        )
        self.assertEqual(made.returncode, 1, made.stderr)
        self.assertIn("No echo of the metal plate", made.stdout.splitlines()[-1])
        history = self.client.data / "daily_checks" / "history.jsonl"
        (line,) = [json.loads(one) for one in history.read_text().splitlines()]
        self.assertEqual((line["simulated"], line["good"]), (True, False))
        nobody = subprocess.run(
            program, input="", capture_output=True, text=True, timeout=CHECK_LIMIT_S
        )
        self.assertEqual(nobody.returncode, 3, nobody.stdout)
        self.assertEqual(len(history.read_text().splitlines()), 1)


if __name__ == "__main__":
    rostest.rosrun("gpr20_main_control", "drift", DriftTest)
