#!/usr/bin/env python3
"""An analyzer that is less kind than its manual: what is read, what is stored, how it ends."""

import json
import shutil
import threading
import time
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from survey_client import SurveyClient, json_traces

from gpr20_common.low.catalogue_file import FOLDER, read_translations
from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import ControlStatus
from gpr20_simulator.srv import SetFault

TRACES = 18
POINTS = 501
OWN = {"if_bandwidth_hz": 10_000.0, "averages": 1, "output_power": "HIGH"}
# Changes by hand, and what they change.
HANDS = {
    "HAND_BANDWIDTH": "the IF bandwidth",
    "HAND_AVERAGES": "the number of averages",
    "HAND_POWER": "the output power",
    "HAND_START": "the start frequency",
}
SPANISH = read_translations(FOLDER / "es.po")
# As in the configuration of this test [s], and how long the steps of such a request may take.
REQUEST_LIMIT_S = 10.0
LONGEST_REQUEST_S = 30.0
# main_control says what it waits for within this time [s].
SAID_WITHIN_S = 3.0
FOUND_WITHIN_S = 30.0


class InstrumentFaultsTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("instrument_faults_rostest")
        cls.client = SurveyClient()
        cls.set_fault = rospy.ServiceProxy("simulator/set_fault", SetFault)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def tearDown(self):
        self.fault("NONE")
        # A test that failed must not be in the way of the next one.
        if self.client.statuses and self.client.statuses[-1].code == ControlStatus.PAUSED:
            self.client.stop()
            self.client.wait_for_status(ControlStatus.STOPPED)

    def fault(self, *names, count=0):
        for name in names:
            answer = type(self).set_fault("vna", name, count)
            self.assertTrue(answer.success, answer.message)

    def begin(self, **changes):
        return self.client.begin(**{"frequency_points": POINTS, **changes})

    def wait_for_end(self):
        """Return the status with which the survey ends or pauses; all of it is in Spanish too."""
        status = self.client.wait_for_status(
            ControlStatus.FINISHED, ControlStatus.PAUSED, ControlStatus.FAILED
        )
        for one in message_from(status).nested():
            self.assertIn(one.template, SPANISH)
        return status

    def wait_for_pause(self, code, *values):
        status = self.wait_for_end()
        self.assertEqual(status.code, ControlStatus.PAUSED, status.message)
        self.assertEqual(status.fault_code, code, status.message)
        for value in values:
            self.assertIn(value, status.message)

    def check_complete(self, survey_id, **settings):
        """The survey must end with every point once, measured by a sweep of its own."""
        status = self.wait_for_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        stored = json_traces(self.client.folder(survey_id))
        self.assertEqual([one["index"] for one in stored], list(range(TRACES)))
        sweeps = [one["s21_real"][0] for one in stored]
        self.assertEqual(len(set(sweeps)), TRACES, "a sweep was stored twice")
        for one in stored:
            self.assertEqual(set(one["s21_real"]), {one["s21_real"][0]}, "two sweeps are mixed")
            place = np.float32(one["x_coord_mm"] + one["y_coord_mm"] / 1000.0)
            self.assertEqual(set(one["s21_imag"]), {float(place)})
            for name, value in {**OWN, **settings}.items():
                self.assertEqual(one[name], value, name)
        return stored

    def check_never_paused(self):
        self.assertNotIn(ControlStatus.PAUSED, [one.code for one in self.client.statuses])

    def metadata(self, survey_id):
        return json.loads((self.client.folder(survey_id) / "survey.json").read_text())

    def test_01_a_bit_that_clears_late_and_slow_points_give_fresh_sweeps(self):
        self.fault("LATE_BIT", "SLOW_POINTS")
        self.check_complete(self.begin())
        self.check_never_paused()

    def test_02_a_bit_that_becomes_late_during_a_survey_gives_fresh_sweeps(self):
        survey_id = self.begin()
        self.client.wait_for_visited(3)
        self.fault("LATE_BIT", "SLOW_POINTS")
        self.check_complete(survey_id)
        self.check_never_paused()

    def test_03_a_query_without_an_answer_is_a_remark_of_the_first_trace(self):
        self.fault("UNANSWERED_QUERY")
        stored = self.check_complete(self.begin())
        self.check_never_paused()
        remarked = [one["index"] for one in stored if "does not report" in " ".join(one["quality"])]
        self.assertEqual(remarked, [0])

    def test_04_a_narrow_if_bandwidth_makes_each_sweep_slow_and_nothing_else(self):
        wanted = {"if_bandwidth_hz": 20.0, "output_power": "LOW", "averages": 1}
        survey_id = self.begin(frequency_points=51, **wanted)
        stored = self.check_complete(survey_id, **wanted)
        self.assertEqual({len(one["s21_real"]) for one in stored}, {51})
        parameters = self.metadata(survey_id)["parameters"]
        self.assertEqual({name: parameters[name] for name in wanted}, wanted)

    def test_05_averages_are_whole_and_the_next_survey_sets_everything_back(self):
        survey_id = self.begin(frequency_points=51, **{**OWN, "averages": 4})
        status = self.wait_for_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        for one in json_traces(self.client.folder(survey_id)):
            self.assertEqual({name: one[name] for name in OWN}, {**OWN, "averages": 4})
        self.check_complete(self.begin(**OWN))

    def test_06_a_hand_at_the_front_panel_makes_the_robot_go_back(self):
        survey_id = self.begin()
        for number, fault in enumerate(HANDS):
            self.client.wait_for_visited(2 + 3 * number)
            self.fault(fault, count=1)
        self.check_complete(survey_id)
        self.check_never_paused()
        changed = [
            one.message for one in self.client.statuses if one.fault_code == "vna.settings_changed"
        ]
        for fault, setting in HANDS.items():
            said = [one for one in changed if setting in one]
            self.assertTrue(said, f"{fault}: nobody was informed")

    def test_07_a_link_that_is_lost_for_half_the_limit_is_waited_for(self):
        for outage_s in (2, 5):
            survey_id = self.begin()
            self.client.wait_for_visited(3)
            self.client.forget()
            begun_s = time.monotonic()
            self.fault("LINK_GONE", count=outage_s)
            if outage_s > SAID_WITHIN_S:
                self.client.wait(
                    lambda: any(
                        one.fault_code == "survey.takes_long" for one in self.client.statuses
                    )
                )
                # While the link is gone: the sweep before may have ended well, and a computer
                # may stall.
                self.assertLess(time.monotonic() - begun_s, outage_s)
            self.check_complete(survey_id)
            self.check_never_paused()

    def test_08_a_link_that_stays_lost_pauses_the_survey_within_its_time(self):
        survey_id = self.begin()
        self.client.wait_for_visited(3)
        begun_s = time.monotonic()
        self.fault("LINK_GONE")
        self.wait_for_pause("vna.no_link", "127.0.0.1")
        self.assertGreater(time.monotonic() - begun_s, 0.75 * REQUEST_LIMIT_S)
        self.assertLess(time.monotonic() - begun_s, LONGEST_REQUEST_S)
        self.fault("NONE")
        self.client.go_on(survey_id)
        self.check_complete(survey_id)

    def test_09_another_serial_number_needs_the_consent_of_the_operator(self):
        survey_id = self.begin()
        self.client.wait_for_visited(3)
        self.fault("OTHER_SERIAL")
        self.fault("DROP", count=1)
        self.wait_for_pause("vna.replaced", "SIMULATED-2")
        # The first resumption finds out; each one without consent is refused with both names.
        for _ in range(2):
            answer = self.client.resume(survey=survey_id)
            if answer.success:
                self.client.wait(lambda: self.client.statuses[-1].code != ControlStatus.PAUSED)
                self.wait_for_pause("vna.replaced", "SIMULATED-2")
                answer = self.client.resume(survey=survey_id)
            self.assertFalse(answer.success)
            self.assertIn("SIMULATED-2", answer.other_analyzer)
        wrong = self.client.resume(survey=survey_id, accept_analyzer="Anritsu,MS2026C/2,7,1.23")
        self.assertFalse(wrong.success)
        self.client.forget()
        accepted = self.client.resume(survey=survey_id, accept_analyzer=answer.other_analyzer)
        self.assertTrue(accepted.success, accepted.message)
        self.client.wait(
            lambda: any(one.code != ControlStatus.PAUSED for one in self.client.statuses)
        )
        self.check_complete(survey_id)
        text = json.dumps(self.metadata(survey_id))
        for identity in ("Anritsu,MS2026C/2,SIMULATED,1.23", answer.other_analyzer):
            self.assertIn(identity, text)

    def test_10_a_calibration_that_is_lost_on_a_write_is_named_and_one_is_enough(self):
        self.fault("LOSES_CALIBRATION")
        _survey_id, status = self.client.run_to_end(frequency_points=401)
        self.assertEqual(status.code, ControlStatus.FAILED)
        self.assertEqual(status.fault_code, "vna.calibration_lost", status.message)
        # The operator calibrates; the settings are already right and are not written again.
        self.fault("NONE")
        self.fault("LOSES_CALIBRATION")
        _survey_id, status = self.client.run_to_end(frequency_points=401)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)

    def test_11_digits_without_end_are_an_error_and_no_wait(self):
        survey_id = self.begin()
        self.client.wait_for_visited(3)
        begun_s = time.monotonic()
        self.fault("ENDLESS_DIGITS")
        self.wait_for_pause("vna.bad_data")
        self.assertLess(time.monotonic() - begun_s, LONGEST_REQUEST_S)
        self.fault("NONE")
        self.client.go_on(survey_id)
        self.check_complete(survey_id)

    def test_12_a_server_that_cannot_clear_is_good_enough(self):
        for fault in ("NO_CLEAR", "CLEAR_UNSUPPORTED"):
            self.fault(fault)
            self.check_complete(self.begin())
            self.fault("NONE")

    def test_14_a_display_that_follows_the_bit_late_gives_fresh_sweeps(self):
        self.fault("LATE_MEMORY")
        self.check_complete(self.begin())
        self.check_never_paused()

    def test_15_a_display_that_becomes_late_during_a_survey_gives_fresh_sweeps(self):
        survey_id = self.begin()
        self.client.wait_for_visited(3)
        self.fault("LATE_MEMORY")
        self.check_complete(survey_id)
        self.check_never_paused()

    def test_16_another_instrument_on_the_same_link_is_noticed_at_the_next_point(self):
        survey_id = self.begin()
        self.client.wait_for_visited(3)
        self.fault("SWAPPED")
        self.wait_for_pause("vna.replaced", "SIMULATED-2")
        self.fault("NONE")
        self.client.go_on(survey_id)
        for one in self.check_complete(survey_id):
            (value,) = one["aux"]
            self.assertEqual((value["name"], value["value"]), ("vna_temperature", 40.0))
        details = self.metadata(survey_id)["instrument"]["calibration_details"]
        self.assertEqual(details["parameters"], ["S11", "S12", "S21", "S22"])

    def test_13_after_a_survey_the_instrument_is_left_to_its_front_panel(self):
        self.check_complete(self.begin())
        released = threading.Event()

        def note(report):
            for status in report.status:
                values = {pair.key: pair.value for pair in status.values}
                # The simulator reports both.
                if values.get("vna_is_remote") == "False" and values["vna_is_continuous"] == "True":
                    released.set()

        subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, note)
        self.assertTrue(released.wait(FOUND_WITHIN_S), "the instrument is still remote")
        subscriber.unregister()


if __name__ == "__main__":
    rostest.rosrun("gpr20", "instrument_faults", InstrumentFaultsTest)
