#!/usr/bin/env python3
"""A survey with an analyzer of scikit-rf: what it stores, and what its faults do."""

import json
import shutil
import sys
import time
import unittest
from pathlib import Path

import rospkg
import rospy
import rostest

from gpr20_msgs.msg import ControlStatus

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, str(Path(rospkg.RosPack().get_path("gpr20")) / "test/ros"))
sys.path.insert(0, str(Path(rospkg.RosPack().get_path("gpr20_scikit_rf")) / "test/unit"))
from scpi_analyzers import SERIAL, PnaAnalyzer, ScpiServer
from survey_client import SurveyClient, described, json_traces

# As in the configuration of this test.
PORT = 25025
ADDRESS = f"TCPIP0::127.0.0.1::{PORT}::SOCKET"


class OtherVnaTest(unittest.TestCase):
    """The analyzer numbers its sweeps."""

    @classmethod
    def setUpClass(cls):
        cls.vna = PnaAnalyzer()
        cls.server = ScpiServer(cls.vna, PORT)
        rospy.init_node("other_vna_rostest")
        cls.client = SurveyClient()

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        shutil.rmtree(cls.client.data, ignore_errors=True)

    def tearDown(self):
        self.vna.serial = SERIAL

    def finished(self, survey_id):
        """Return survey.json and the traces of a survey that ended well."""
        status = self.client.wait_for_status(
            ControlStatus.FINISHED, ControlStatus.FAILED, ControlStatus.PAUSED
        )
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        folder = self.client.folder(survey_id)
        return json.loads((folder / "survey.json").read_text()), json_traces(folder)

    def assert_fresh(self, traces):
        sweeps = [set(trace["s21_real"]) for trace in traces]
        self.assertTrue(all(len(numbers) == 1 for numbers in sweeps), sweeps)
        order = [next(iter(numbers)) for numbers in sweeps]
        self.assertEqual(order, sorted(set(order)))

    def test_a_survey_stores_fresh_sweeps_of_the_configured_address(self):
        self.assertEqual(described("vna_acquisition")["address"], ADDRESS)
        survey, traces = self.finished(self.client.begin(vna_address="", averages=2))
        self.assertEqual(len(traces), 18)
        self.assert_fresh(traces)
        self.assertEqual(survey["instrument"]["identity"], self.vna.identity)
        self.assertEqual(survey["instrument"]["address"], ADDRESS)
        self.assertEqual(survey["instrument"]["calibration_status"], 5)
        self.assertEqual(survey["analyzer"]["antenna_delay_ns"], 0.3)
        self.assertEqual({trace["averages"] for trace in traces}, {2})
        self.assertEqual({trace["if_bandwidth_hz"] for trace in traces}, {1e5})

    def test_a_link_that_drops_repeats_a_sweep_and_nothing_more(self):
        survey_id = self.client.begin(vna_address="")
        self.client.wait_for_visited(2)
        self.server.drop_all()
        self.client.wait_for_visited(5)
        self.vna.faults.drop_at = "*OPC?"
        _survey, traces = self.finished(survey_id)
        self.assertEqual(len(traces), 18)
        self.assert_fresh(traces)
        remarks = [remark for trace in traces for remark in trace["quality"]]
        self.assertTrue(any("repeated once" in remark for remark in remarks), remarks)

    def test_another_serial_number_pauses_the_survey(self):
        self.client.begin(vna_address="")
        self.client.wait_for_visited(2)
        self.vna.serial = "SIMULATED-2"
        self.server.drop_all()
        status = self.client.wait_for_status(ControlStatus.PAUSED, ControlStatus.FINISHED)
        self.assertEqual(status.code, ControlStatus.PAUSED, status.message)
        self.assertEqual(status.fault_code, "vna.replaced", status.message)
        self.assertIn("SIMULATED-2", status.message)
        self.assertTrue(self.client.stop().success)
        self.client.wait_for_status(ControlStatus.STOPPED)

    def test_an_address_of_another_kind_is_refused(self):
        self.client.begin(vna_address="127.0.0.1")
        status = self.client.wait_for_status(ControlStatus.FAILED, ControlStatus.PAUSED)
        self.assertEqual(status.fault_code, "value.not_allowed", status.message)
        self.assertIn("127.0.0.1", status.message)
        if status.code == ControlStatus.PAUSED:
            self.assertTrue(self.client.stop().success)
            self.client.wait_for_status(ControlStatus.STOPPED)

    def test_after_a_survey_it_sweeps_by_itself(self):
        self.finished(self.client.begin(vna_address=""))
        deadline_s = time.monotonic() + 10.0
        while not self.vna.is_continuous and time.monotonic() < deadline_s:
            time.sleep(0.01)
        self.assertTrue(self.vna.is_continuous)


if __name__ == "__main__":
    rostest.rosrun("gpr20_scikit_rf", "other_vna", OtherVnaTest)
