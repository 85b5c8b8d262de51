#!/usr/bin/env python3
"""The services of the network analyzer against the simulated instrument's real port.

The simulated medium answers with the number of the sweep in every real part.
"""

from __future__ import annotations

import time
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Severity
from gpr20_common.sent_message import message_from, received_message
from gpr20_msgs.srv import (
    ConfirmData,
    Connection,
    FreqSweepSetup,
    FreqSweepSetupRequest,
    GetCalibrationStatus,
    GetCalibrationStatusResponse,
    GetData,
    GetFreq,
)
from gpr20_simulator.srv import SetFault
from gpr20_vna_acquisition import faults

SERVICES = {
    "confirm_data": ConfirmData,
    "connection": Connection,
    "freq_sweep_setup": FreqSweepSetup,
    "get_freq": GetFreq,
    "get_data": GetData,
    "get_calibration_status": GetCalibrationStatus,
    "simulator/set_fault": SetFault,
}
START_HZ, STOP_HZ, POINTS = 600e6, 6e9, 101
# As in the launch file.
REQUEST_TIMEOUT_S = 3.0
FIND_LIMIT_S = 60.0


class VnaAcquisitionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_vna_acquisition")
        cls.services = {}
        for name, service_class in SERVICES.items():
            rospy.wait_for_service(name, FIND_LIMIT_S)
            cls.services[name] = rospy.ServiceProxy(name, service_class)

    def setUp(self):
        self.fault("none")

    def call(self, name, *arguments):
        return self.services[name](*arguments)

    def fault(self, name, count=0):
        answer = self.call("simulator/set_fault", "vna", name, count)
        self.assertTrue(answer.success, answer.message)

    def connect(self):
        answer = self.call("connection", True, "127.0.0.1")
        self.assertTrue(answer.success, answer.message)
        return answer

    def set_up_sweep(self, points=POINTS):
        self.connect()
        answer = self.sweep_setup(points=points)
        self.assertTrue(answer.success, answer.message)
        return answer

    def sweep_setup(self, start_hz=START_HZ, stop_hz=STOP_HZ, points=POINTS, **settings):
        return self.services["freq_sweep_setup"](
            FreqSweepSetupRequest(
                start_frequency_hz=start_hz, stop_frequency_hz=stop_hz, points=points, **settings
            )
        )

    def assert_refused(self, answer, fault, *shown):
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault_code, fault.code, answer.message)
        self.assertEqual(message_from(answer).cause, fault)
        for value in shown:
            self.assertIn(str(value), answer.message)

    def test_connecting_tells_who_is_there(self):
        self.assertTrue(self.connect().identity.startswith("Anritsu,MS2026C/2,SIMULATED"))

    def test_set_up_answers_what_the_instrument_took(self):
        answer = self.set_up_sweep()
        taken = (answer.start_frequency_hz, answer.stop_frequency_hz, answer.points)
        self.assertEqual(taken, (START_HZ, STOP_HZ, POINTS))

    def test_set_up_answers_the_analyzers_own_settings_and_how_long_a_sweep_takes(self):
        answer = self.set_up_sweep()
        own = (answer.if_bandwidth_hz, answer.averages, answer.output_power)
        self.assertEqual(own, (10_000.0, 1, "HIGH"))
        self.assertGreaterEqual(answer.sweep_duration_s, POINTS * 350e-6)
        self.assertGreater(answer.request_limit_s, REQUEST_TIMEOUT_S)

    def test_settings_of_the_analyzer_are_made_and_come_with_the_data(self):
        self.connect()
        # The instrument keeps them, and other tests would be slow.
        own = {"if_bandwidth_hz": 10_000.0, "averages": 1, "output_power": "HIGH"}
        self.addCleanup(self.sweep_setup, **own)
        answer = self.sweep_setup(if_bandwidth_hz=1000.0, averages=3, output_power="LOW")
        self.assertTrue(answer.success, answer.message)
        # 1 kHz needs 0.9 ms more per point than the 10 kHz of power-on.
        self.assertGreaterEqual(answer.sweep_duration_s, 3 * POINTS * 1.25e-3)
        data = self.call("get_data", False)
        self.assertTrue(data.success, data.message)
        self.assertEqual(
            (data.if_bandwidth_hz, data.averages, data.output_power), (1000.0, 3, "LOW")
        )

    def test_settings_that_the_analyzer_does_not_have_are_refused_with_those_it_has(self):
        self.connect()
        for settings, words in (
            ({"if_bandwidth_hz": 30_000.0}, "50000, 100000"),
            ({"averages": 65_536}, "65535"),
            ({"output_power": "LOUD"}, "LOW, HIGH"),
        ):
            self.assert_refused(self.sweep_setup(**settings), NOT_ALLOWED, words)

    def test_data_can_be_confirmed_later_and_only_once(self):
        self.set_up_sweep()
        data = self.call("get_data", True)
        self.assertTrue(data.success, data.message)
        answer = self.call("confirm_data", data.number)
        self.assertTrue(answer.success, answer.message)
        again = self.call("confirm_data", data.number)
        self.assert_refused(again, faults.SWEEP_UNCONFIRMED, data.number)
        self.assertTrue(again.repeat)

    def test_frequencies_are_exact(self):
        self.set_up_sweep()
        answer = self.call("get_freq")
        self.assertTrue(answer.success)
        self.assertEqual(list(answer.frequency_hz), np.linspace(START_HZ, STOP_HZ, POINTS).tolist())

    def test_each_request_gets_one_new_sweep_that_began_after_it(self):
        self.set_up_sweep()
        numbers = []
        for _ in range(4):
            requested = rospy.Time.from_sec(time.time())
            answer = self.call("get_data", False)
            self.assertTrue(answer.success, answer.message)
            self.assertEqual((len(answer.s21_real), len(answer.s21_imag)), (POINTS, POINTS))
            self.assertEqual(len(set(answer.s21_real)), 1, "points of two sweeps are mixed")
            self.assertGreaterEqual(answer.sweep_started, requested - rospy.Duration(0, 1000))
            took_s = (answer.sweep_ended - answer.sweep_started).to_sec()
            self.assertGreaterEqual(took_s, POINTS * 350e-6)
            self.assertEqual(answer.sweep_started.nsecs % 1000, 0)
            # The probe answers with one large number: both get a remark, neither is refused.
            self.assertGreaterEqual(len(answer.quality), 2)
            self.assertIn(str(POINTS), answer.quality[1])
            numbers.append(answer.s21_real[0])
        self.assertEqual(numbers, sorted(set(numbers)))

    def test_the_whole_number_of_points_is_transferred(self):
        self.set_up_sweep(points=4000)
        self.assertEqual(len(self.call("get_data", False).s21_imag), 4000)

    def test_calibration_status_is_named(self):
        self.connect()
        answer = self.call("get_calibration_status")
        self.assertTrue(answer.success)
        self.assertEqual(
            (answer.status, answer.message, answer.fault_code),
            (GetCalibrationStatusResponse.HIGH, "HIGH", ""),
        )

    def test_diagnostics_have_the_code_of_what_is_told(self):
        self.assertTrue(self.call("connection", False, "").success)
        status, values = self.wait_for_report(lambda _, values: values["address"] == "")
        self.assertEqual(values["fault_code"], faults.UNUSED.code)
        self.assertIs(received_message("", values["message_json"]).cause.severity, Severity.NOTE)
        self.set_up_sweep()
        self.wait_for_report(lambda _, values: values["fault_code"] == "")
        self.assertTrue(self.call("get_data", False).success)
        status, values = self.wait_for_report(lambda _, values: values["fault_code"])
        self.assertEqual((status.level, values["fault_code"]), (1, faults.STRONG.code))

    def test_refused_values_are_named_with_their_limit(self):
        self.set_up_sweep()
        for values, words in (
            ((float("nan"), STOP_HZ, POINTS), "nan"),
            ((0.0, STOP_HZ, POINTS), "0 Hz"),
            ((STOP_HZ, START_HZ, POINTS), str(int(STOP_HZ))),
            ((START_HZ, 7e9, POINTS), "6000000000"),
            ((START_HZ, STOP_HZ, 4001), "4000"),
            ((START_HZ, STOP_HZ, 1), "4000"),
        ):
            self.assert_refused(self.sweep_setup(*values), NOT_ALLOWED, words)
        # What was refused changed nothing.
        self.assertEqual(len(self.call("get_data", False).s21_real), POINTS)

    def test_an_address_that_is_none_is_refused(self):
        for address in ("", "192.168.1", "1.2.3.256", "example.org"):
            answer = self.call("connection", True, address)
            self.assert_refused(answer, NOT_ALLOWED, f"'{address}'")

    def test_nothing_works_before_its_time(self):
        self.assertTrue(self.call("connection", False, "").success)
        self.assert_refused(self.call("get_data", False), faults.NOT_CONNECTED)
        self.assert_refused(self.call("get_freq"), faults.NOT_CONNECTED)
        self.assert_refused(self.call("confirm_data", 1), faults.NOT_CONNECTED)
        self.assert_refused(self.call("get_calibration_status"), faults.NOT_CONNECTED)
        self.connect()
        self.assert_refused(self.call("get_data", False), faults.NOT_CONFIGURED)

    def test_a_silent_address_is_answered_in_time(self):
        # The port lookup serves 127.x.x.x, so the silence comes from a network without hosts:
        # 192.0.2.0/24 is reserved for documentation.
        begun_s = time.monotonic()
        answer = self.call("connection", True, "192.0.2.1")
        self.assertLess(time.monotonic() - begun_s, 10.0)
        self.assert_refused(answer, faults.NO_LINK, "192.0.2.1")
        self.assertEqual(message_from(answer).values["address"], "192.0.2.1")

    def test_another_instrument_is_refused(self):
        self.fault("wrong_identity")
        answer = self.call("connection", True, "127.0.0.1")
        self.assert_refused(answer, faults.WRONG_INSTRUMENT, "Anritsu")

    def test_a_refused_setting_is_told_and_nothing_is_measured(self):
        self.set_up_sweep()
        self.fault("refuse_settings")
        answer = self.sweep_setup(points=POINTS + 1)
        self.assert_refused(answer, faults.SETTING_REFUSED, POINTS + 1)
        self.assert_refused(self.call("get_data", False), faults.NOT_CONFIGURED)

    def test_a_single_failure_is_repeated_and_never_becomes_data(self):
        self.set_up_sweep()
        for fault in ("hang", "drop", "silent", "truncate", "nan", "garbage", "stale"):
            # The data of a stale sweep can only be known as those of the sweep before.
            self.assertTrue(self.call("get_data", False).success)
            self.fault(fault, 1)
            answer = self.call("get_data", False)
            self.assertTrue(answer.success, f"{fault}: {answer.message}")
            self.assertEqual(len(answer.s21_real), POINTS)
            self.assertEqual(len(set(answer.s21_real)), 1, fault)
            # A setting that was read back as garbage is just read again.
            if fault != "garbage":
                self.assertGreaterEqual(len(answer.quality), 3, fault)

    def test_a_lasting_failure_is_told_and_the_next_sweep_is_good(self):
        self.set_up_sweep()
        for fault, expected in (
            ("truncate", faults.BAD_DATA),
            ("nan", faults.BAD_DATA),
            ("drop", faults.NO_LINK),
        ):
            self.fault(fault)
            self.assert_refused(self.call("get_data", False), expected)
            self.fault("none")
            answer = self.call("get_data", False)
            self.assertTrue(answer.success, f"after {fault}: {answer.message}")

    def test_diagnostics_tell_the_instrument_and_the_last_sweep(self):
        self.set_up_sweep()
        self.assertTrue(self.call("get_data", False).success)
        _, values = self.wait_for_report(lambda _, values: values["address"] == "127.0.0.1")
        self.assertIn("MS2026C", values["identity"])
        self.assertGreaterEqual(float(values["last sweep [s]"]), POINTS * 350e-6)

    def test_a_link_that_dies_while_nobody_uses_it_is_told_until_it_is_back(self):
        self.set_up_sweep()
        self.wait_for_report(lambda status, _: status.level == DiagnosticStatus.OK)
        self.fault("drop")
        fault, values = self.wait_for_report(lambda status, _: status.level > DiagnosticStatus.OK)
        self.assertIn("127.0.0.1", fault.message)
        message = received_message("", values["message_json"])
        self.assertEqual(message.values["address"], "127.0.0.1")
        self.assertEqual(values["linked"], "False")
        self.fault("none")
        self.wait_for_report(lambda status, _: status.level == DiagnosticStatus.OK)
        self.assertTrue(self.call("get_data", False).success, "the sweep was not set up again")

    def test_the_fault_of_a_sweep_ends_soon_after_its_cause(self):
        for fault in ("drop", "silent", "nan"):
            self.set_up_sweep()
            self.fault(fault)
            self.assertFalse(self.call("get_data", False).success)
            self.wait_for_report(lambda status, _: status.level == DiagnosticStatus.ERROR)
            self.fault("none")
            begun_s = time.monotonic()
            _, values = self.wait_for_report(lambda one, _: one.level < DiagnosticStatus.ERROR)
            self.assertEqual(values["fault_code"], faults.ANSWERS_AGAIN.code)
            # The check of the idle link, one report, and what the last exchange still waits for.
            self.assertLess(time.monotonic() - begun_s, 6.0, fault)

    def wait_for_report(self, accepted):
        """Return the first report of the node that is accepted, and its values."""
        deadline_s = time.monotonic() + FIND_LIMIT_S
        while time.monotonic() < deadline_s:
            report = rospy.wait_for_message("/diagnostics", DiagnosticArray, FIND_LIMIT_S)
            for status in report.status:
                values = {pair.key: pair.value for pair in status.values}
                if "vna_acquisition" in status.name and accepted(status, values):
                    return status, values
        return self.fail("the diagnostics did not report this")


if __name__ == "__main__":
    rostest.rosrun("gpr20_vna_acquisition", "test_vna_acquisition", VnaAcquisitionTest)
