#!/usr/bin/env python3
"""Every fault of the simulated robot: what the operator reads, and that the survey continues.

A survey that meets a fault pauses; nothing wrong is stored; once the fault is gone it ends
with every point exactly once.
"""

import os
import shutil
import signal
import time
import unittest

import numpy as np
import rospy
import rostest
import vxi11
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
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.srv import SetFault
from gpr20_survey.axes.axis_id import AxisId

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

    FAR_MM = 600.0

    @classmethod
    def setUpClass(cls):
        rospy.init_node("faults_rostest")
        cls.client = SurveyClient()
        cls.state = open_shared_state(shared_state_path("/"))
        cls.set_fault = rospy.ServiceProxy("simulator/set_fault", SetFault)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def tearDown(self):
        for device in ("vna", "adc", "endstop_x", "endstop_y"):
            self.fault(device, "NONE")
        # A test that failed must not be in the way of the next one.
        if self.client.statuses and self.client.statuses[-1].code == ControlStatus.PAUSED:
            self.client.stop()
            self.client.wait_for_status(ControlStatus.STOPPED)

    def fault(self, device, name, count=0):
        answer = type(self).set_fault(device, name, count)
        self.assertTrue(answer.success, answer.message)

    def true_steps(self):
        return [self.state.steps(axis) for axis in AxisId]

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
            self.assertEqual((len(one["s21_real"]), len(one["s21_imag"])), (51, 51))
            self.assertAlmostEqual(one["antennae_height_m"], 0.20, delta=0.01)

    def test_00_every_service_refuses_with_a_sentence(self):
        for name, service_class, *arguments in REFUSED:
            rospy.wait_for_service(name, LIMIT_S)
            answer = rospy.ServiceProxy(name, service_class)(*arguments)
            self.assertIs(answer.success, False, name)
            self.assertGreater(len(answer.message.split()), 4, f"{name}: {answer.message}")
            self.assertNotIn("internal error", answer.message)

    # The endstops. These come first, because the first survey is the one that homes.

    def test_01_an_endstop_stuck_open_at_homing(self):
        self.fault("endstop_x", "STUCK_OPEN")
        survey_id = self.client.begin()
        self.wait_for_pause("axis.endstop_not_reached")
        self.assertEqual(json_traces(self.client.folder(survey_id)), [])
        self.fault("endstop_x", "NONE")
        self.finish(survey_id)

    def test_02_an_endstop_that_closes_in_a_move_and_stays_closed_at_homing(self):
        # The second row leads towards the endstop of x, and takes long enough to be met.
        survey_id = self.begin_and_meet(
            "endstop_x", ("STUCK_CLOSED", 0), after=7, x_stop_mm=self.FAR_MM
        )
        self.wait_for_pause("axis.endstop_pressed")
        self.client.go_on(survey_id)
        self.wait_for_pause("axis.endstop_stuck")
        self.fault("endstop_x", "NONE")
        self.finish(survey_id)
        # The axis has its zero back: it is where it reports to be.
        self.assertEqual(self.state.steps(AxisId.X), 100 * self.FAR_MM)

    def test_03_an_endstop_stuck_open_does_no_harm_before_the_next_homing(self):
        self.check_complete(self.begin_and_meet("endstop_y", ("STUCK_OPEN", 0)))

    # The network analyzer.

    def check_vna_fault(self, fault, code, *values):
        survey_id = self.begin_and_meet("vna", (fault, 0))
        self.wait_for_pause(code, *values)
        self.fault("vna", "NONE")
        self.finish(survey_id)

    def test_10_an_instrument_that_hangs(self):
        self.check_vna_fault("HANG", "vna.no_link", "127.0.0.1")

    def test_11_an_instrument_that_drops_its_connections(self):
        self.check_vna_fault("DROP", "vna.no_link", "127.0.0.1")

    def test_12_an_instrument_that_stays_silent(self):
        self.check_vna_fault("SILENT", "vna.no_answer", "127.0.0.1")

    def test_13_an_instrument_that_answers_late(self):
        self.check_vna_fault("LATE", "vna.no_answer", "127.0.0.1")

    def test_14_a_block_that_is_cut(self):
        self.check_vna_fault("TRUNCATE", "vna.bad_data")

    def test_15_numbers_that_are_none(self):
        self.check_vna_fault("NAN", "vna.bad_data")

    def test_16_an_instrument_that_babbles(self):
        self.check_vna_fault("GARBAGE", "vna.wrong_instrument", "MS2026C")

    def test_17_data_of_the_sweep_before(self):
        self.check_vna_fault("STALE", "vna.old_data")

    def test_18_another_instrument_at_the_same_address(self):
        # Only a new link asks who is there.
        survey_id = self.begin_and_meet("vna", ("WRONG_IDENTITY", 0), ("DROP", 1))
        self.wait_for_pause("vna.wrong_instrument", "Rohde&Schwarz,ZNL6")
        self.fault("vna", "NONE")
        self.finish(survey_id)

    def test_19_settings_that_are_refused(self):
        # The instrument keeps what it has, so it must have something else to be noticed.
        survey_id = self.begin_and_meet("adc", ("STUCK", 0))
        self.wait_for_pause("height.sensor_off")
        self.turn_knob(":SENS:FREQ:STAR 700E6")
        self.fault("vna", "REFUSE_SETTINGS")
        self.fault("adc", "NONE")
        self.client.go_on(survey_id)
        self.wait_for_pause("vna.setting_refused", "600000000")
        self.fault("vna", "NONE")
        self.finish(survey_id)

    def test_20_settings_that_are_refused_from_the_start_fail_the_survey_before_it_moves(self):
        before = self.true_steps()
        self.fault("vna", "REFUSE_SETTINGS")
        _survey_id, status = self.client.run_to_end(frequency_points=52)
        self.assertEqual(status.code, ControlStatus.FAILED)
        self.assertEqual(status.fault_code, "vna.setting_refused", status.message)
        for points in ("51", "52"):
            self.assertIn(points, status.message)
        self.assertEqual(self.true_steps(), before)

    def turn_knob(self, command):
        """Change the instrument as a hand at its front panel would."""
        panel = vxi11.Instrument("127.0.0.1")
        panel.client = vxi11.vxi11.CoreClient("127.0.0.1", self.state.vna_port)
        panel.write(command)
        panel.close()

    # The converter of the height sensor.

    def check_adc_fault(self, fault, code, *values):
        survey_id = self.begin_and_meet("adc", (fault, 0))
        self.wait_for_pause(code, *values)
        self.fault("adc", "NONE")
        self.finish(survey_id)

    def test_30_a_converter_that_is_stuck(self):
        self.check_adc_fault("STUCK", "height.sensor_off")

    def test_31_a_height_out_of_range(self):
        self.check_adc_fault("OUT_OF_RANGE", "height.out_of_range", "0.1", "0.8")

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


def cpu_s(pid):
    """Return the time of a processor that a process has used [s].

    Not from `stat`, which samples and misses threads that run for less than a tick. The clock is
    numbered as by clock_getcpuclockid(3), which Python does not offer.
    """
    scheduler_clock = 2
    return time.clock_gettime((~pid << 3) | scheduler_clock)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "faults", FaultsTest)
