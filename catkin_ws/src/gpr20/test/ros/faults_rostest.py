#!/usr/bin/env python3
"""What a fault is on the graph: what the operator reads, and that the survey continues.

The faults themselves are in test_surveys_with_faults.py. A survey that meets one pauses; nothing
wrong is stored; once the fault is gone it ends with every point exactly once.
"""

import os
import shutil
import signal
import time
import unittest

import numpy as np
import rospy
import rostest
from survey_client import LIMIT_S, SurveyClient, json_traces, node_pid

from gpr20_common.low.catalogue_file import FOLDER, read_translations
from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import (
    ControlStatus,
    SurveyCoverage,
    SurveyData,
    SurveyParameters,
    Trace,
)
from gpr20_msgs.srv import (
    CloseSurvey,
    Command,
    Connection,
    FreqSweepSetup,
    GetCalibrationStatus,
    GetData,
    GetFreq,
    OpenSurvey,
    ResumeSurvey,
    SetSurveyParameters,
    StartSurvey,
    StoreData,
)
from gpr20_simulator.mid.world.medium import probed_rotation_deg
from gpr20_simulator.srv import SetFault

TRACES = 18
NAN = float("nan")
SPANISH = read_translations(FOLDER / "es.po")
LAST_MESSAGES = (ControlStatus(), SurveyData(), SurveyCoverage())
# What each service must refuse before there is a survey or a connection.
REFUSED = (
    ("set_survey_parameters", SetSurveyParameters, SurveyParameters(x_start_mm=NAN)),
    ("start_survey", StartSurvey),
    ("stop_survey", Command),
    ("resume_survey", ResumeSurvey, "", "", False),
    ("connection", Connection, True, "here"),
    ("freq_sweep_setup", FreqSweepSetup, NAN, -1.0, 0, NAN, -1, "\n"),
    ("get_freq", GetFreq),
    ("get_data", GetData, False),
    ("get_calibration_status", GetCalibrationStatus),
    ("open_survey", OpenSurvey, "../..", rospy.Time(), "[]", 2**64 - 1, False),
    ("store_data", StoreData, Trace()),
    ("close_survey", CloseSurvey, "../..", "lost", "", "", *LAST_MESSAGES),
    ("simulator/set_fault", SetFault, "toaster", "BURNT", -1),
)
NODES = (
    "/main_control",
    "/vna_acquisition",
    "/height_sensor",
    *(f"/{axis}_axis/axis_driver" for axis in "xyz"),
)


class FaultsTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("faults_rostest")
        cls.client = SurveyClient()
        cls.set_fault = rospy.ServiceProxy("simulator/set_fault", SetFault)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def tearDown(self):
        for device in ("vna", "adc"):
            self.fault(device, "NONE")
        # A test that failed must not be in the way of the next one.
        if self.client.statuses and self.client.statuses[-1].code == ControlStatus.PAUSED:
            self.client.stop()
            self.client.wait_for_status(ControlStatus.STOPPED)

    def fault(self, device, name, count=0):
        answer = type(self).set_fault(device, name, count)
        self.assertTrue(answer.success, answer.message)

    def wait_for_pause(self, code, *values):
        """Wait until the survey pauses with a fault; the operator must read these values.

        A window in Spanish translates all of it.
        """
        status = self.client.wait_for_status(
            ControlStatus.PAUSED, ControlStatus.FAILED, ControlStatus.FINISHED
        )
        self.assertEqual(status.code, ControlStatus.PAUSED, status.message)
        self.assertEqual(status.fault_code, code, status.message)
        for value in values:
            self.assertIn(value, status.message)
        self.assertTrue(status.message.isprintable(), status.message)
        message = message_from(status)
        self.assertEqual(str(message), status.message)
        for one in message.nested():
            self.assertIn(one.template, SPANISH)

    def begin_and_meet(self, device, *faults, after=3, **changes):
        """Start a survey, switch on faults once some traces are stored; return its id."""
        survey_id = self.client.begin(**changes)
        self.client.wait_for_visited(after)
        for name, count in faults:
            self.fault(device, name, count)
        return survey_id

    def finish(self, survey_id):
        """Resume the paused survey; it must end complete."""
        self.client.go_on(survey_id)
        self.check_complete(survey_id)

    def check_complete(self, survey_id):
        """The survey must end with every point once, all of them right."""
        status = self.client.wait_for_status(
            ControlStatus.FINISHED, ControlStatus.FAILED, ControlStatus.PAUSED
        )
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        stored = json_traces(self.client.folder(survey_id))
        self.assertEqual([one["index"] for one in stored], list(range(TRACES)))
        places = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
        self.assertEqual(len(places), TRACES)
        sweeps = [one["s21_real"][0] for one in stored]
        self.assertEqual(len(set(sweeps)), TRACES, "a sweep was stored twice")
        for one in stored:
            self.assertEqual(set(one["s21_real"]), {one["s21_real"][0]})
            place = np.float32(one["x_coord_mm"] + one["y_coord_mm"] / 1000.0)
            self.assertEqual(set(one["s21_imag"]), {float(place)})
            turned_deg = probed_rotation_deg(one["s21_real"][0])
            self.assertAlmostEqual(turned_deg, one["z_coord_deg"], delta=0.4)
            self.assertEqual((len(one["s21_real"]), len(one["s21_imag"])), (51, 51))
            self.assertAlmostEqual(one["antennae_height_m"], 0.20, delta=0.01)

    def test_00_every_service_refuses_with_a_sentence(self):
        for name, service_class, *arguments in REFUSED:
            rospy.wait_for_service(name, LIMIT_S)
            answer = rospy.ServiceProxy(name, service_class)(*arguments)
            self.assertIs(answer.success, False, name)
            self.assertGreater(len(answer.message.split()), 4, f"{name}: {answer.message}")
            self.assertNotIn("internal error", answer.message)

    # What hangs, and what waits.

    def test_40_a_node_that_hangs_and_answers_when_nobody_asks_any_more(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        pid = node_pid("/vna_acquisition")
        os.kill(pid, signal.SIGSTOP)
        try:
            self.wait_for_pause("survey.part_not_back")
            paused = message_from(self.client.statuses[-1])
            self.assertIn("vna_acquisition", paused.all_details)
        finally:
            os.kill(pid, signal.SIGCONT)
        self.finish(survey_id)

    def test_41_nobody_is_busy_while_a_survey_waits_for_its_operator(self):
        survey_id = self.begin_and_meet("adc", ("STUCK", 0))
        self.wait_for_pause("height.sensor_off")
        pids = {node: node_pid(node) for node in NODES}
        begun_s = time.monotonic()
        before_s = {node: cpu_s(pid) for node, pid in pids.items()}
        time.sleep(1.0)
        for node, pid in pids.items():
            used_s = cpu_s(pid) - before_s[node]
            self.assertLess(used_s, 0.3 * (time.monotonic() - begun_s), node)
        self.fault("adc", "NONE")
        self.finish(survey_id)

    # What the services of the analyzer say beside success.

    def test_42_a_sweep_that_cannot_be_confirmed_is_made_again(self):
        self.check_complete(self.begin_and_meet("vna", ("HAND_POWER", 1)))
        codes = [one.fault_code for one in self.client.statuses]
        self.assertIn("vna.settings_changed", codes)
        self.assertNotIn(ControlStatus.PAUSED, [one.code for one in self.client.statuses])

    def test_43_another_analyzer_needs_the_consent_of_the_operator(self):
        survey_id = self.begin_and_meet("vna", ("OTHER_SERIAL", 0), ("DROP", 1))
        self.wait_for_pause("vna.replaced", "SIMULATED-2")
        # The first resumption finds out, perhaps after its answer.
        answer = self.client.resume(survey=survey_id)
        if answer.success:
            self.client.wait(lambda: self.client.statuses[-1].code != ControlStatus.PAUSED)
            self.wait_for_pause("vna.replaced", "SIMULATED-2")
            answer = self.client.resume(survey=survey_id)
        self.assertFalse(answer.success)
        self.assertIn("SIMULATED-2", answer.other_analyzer)
        self.client.forget()
        accepted = self.client.resume(survey=survey_id, accept_analyzer=answer.other_analyzer)
        self.assertTrue(accepted.success, accepted.message)
        self.client.wait(
            lambda: any(one.code != ControlStatus.PAUSED for one in self.client.statuses)
        )
        self.check_complete(survey_id)


def cpu_s(pid):
    """Return the time of a processor that a process has used [s].

    Not from `stat`, which samples and misses threads that run for less than a tick. The clock is
    numbered as by clock_getcpuclockid(3), which Python does not offer.
    """
    scheduler_clock = 2
    return time.clock_gettime((~pid << 3) | scheduler_clock)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "faults", FaultsTest)
