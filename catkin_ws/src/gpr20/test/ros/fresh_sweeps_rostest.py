#!/usr/bin/env python3
"""No trace can hold a sweep that began before the antennas stood still."""

import shutil
import threading
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
import vxi11
from survey_client import SurveyClient, bits, described, json_traces

from gpr20_msgs.msg import ControlStatus
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.world.medium import probed_rotation_deg

# Between two presses of a key [s]; a survey takes a few seconds.
PRESS_S = 0.4


class FrontPanel:
    """Somebody who switches the instrument back to continuous sweeps now and then."""

    def __init__(self, port):
        self._instrument = vxi11.Instrument("127.0.0.1")
        self._instrument.client = vxi11.vxi11.CoreClient("127.0.0.1", port)
        self._ended = threading.Event()
        self.presses = 0
        self._thread = threading.Thread(target=self._press)
        self._thread.start()

    def _press(self):
        while not self._ended.wait(PRESS_S):
            self._instrument.write(":INIT:CONT ON")
            self.presses += 1

    def leave(self):
        self._ended.set()
        self._thread.join()
        self._instrument.close()


def sent_values(path):
    """Return the complex values of a captured data block, read without the driver's parser."""
    block = path.read_bytes()
    digits = int(block[1:2])
    length = int(block[2 : 2 + digits])
    numbers = np.frombuffer(block[2 + digits : 2 + digits + length], dtype="<f4")
    return numbers.astype(np.float64)


class FreshSweepsTest(unittest.TestCase):
    """The instrument numbers its sweeps and says where each number was measured."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("fresh_sweeps_rostest")
        cls.client = SurveyClient()
        cls.capture = Path(described("simulator")["capture_dir"])

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)
        shutil.rmtree(cls.capture)

    def check_traces(self, stored):
        """Each trace is one whole sweep of its own, measured where the trace says."""
        self.assertEqual(len(stored), 18)
        sweeps = [one["s21_real"][0] for one in stored]
        self.assertEqual(sweeps, sorted(set(sweeps)))
        for one in stored:
            self.assertEqual(set(one["s21_real"]), {one["s21_real"][0]})
            place = np.float32(one["x_coord_mm"] + one["y_coord_mm"] / 1000.0)
            self.assertEqual(set(one["s21_imag"]), {float(place)})
            turned_deg = probed_rotation_deg(one["s21_real"][0])
            self.assertAlmostEqual(turned_deg, one["z_coord_deg"], delta=0.4)

    def test_1_every_trace_is_one_sweep_made_at_its_own_place(self):
        survey_id, status = self.client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        stored = json_traces(self.client.folder(survey_id))
        # It has been sweeping by itself since it was switched on.
        self.assertGreater(stored[0]["s21_real"][0], 10.0)
        self.check_traces(stored)

    def test_2_what_the_instrument_sent_is_what_is_stored_bit_for_bit(self):
        survey_id, status = self.client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        sent = {}
        for path in self.capture.glob("*_sdat.bin"):
            numbers = sent_values(path)
            sent[bits(numbers[0::2]), bits(numbers[1::2])] = path
        for one in json_traces(self.client.folder(survey_id)):
            self.assertIn((bits(one["s21_real"]), bits(one["s21_imag"])), sent)

    def test_3_an_instrument_that_is_switched_back_to_continuous_sweeps_changes_nothing(self):
        panel = FrontPanel(open_shared_state(shared_state_path("/")).vna_port)
        try:
            survey_id, status = self.client.run_to_end()
        finally:
            panel.leave()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        self.assertGreater(panel.presses, 1)
        self.check_traces(json_traces(self.client.folder(survey_id)))


if __name__ == "__main__":
    rostest.rosrun("gpr20", "fresh_sweeps", FreshSweepsTest)
