#!/usr/bin/env python3
"""The node of the network analyzer over the wire to the node of the simulated instrument.

The simulated medium answers with the place of the antennas and the number of the sweep.
"""

from __future__ import annotations

import threading
import time
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.high.answers import message_from
from gpr20_common.sent_message import received_message
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
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.world.medium import probed_position_mm, probed_rotation_deg, probed_sweep
from gpr20_simulator.srv import SetFault
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import CAN_RESUME, VNA_DOUBTFUL, VNA_FAILED
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
ADDRESS = "127.0.0.1"
START_HZ, STOP_HZ, POINTS = 600e6, 6e9, 101
# As in the launch file.
REQUEST_TIMEOUT_S = 20.0
LIMIT_S = 60.0
STEPS_PER_MM = 100
DEG_PER_STEP = 1.8
ERROR, WARN, OK = DiagnosticStatus.ERROR, DiagnosticStatus.WARN, DiagnosticStatus.OK


class Reports:
    """The diagnostics of both nodes."""

    def __init__(self):
        self._changed = threading.Condition()
        self._found = {}
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._receive)

    def wait(self, node, accepted):
        """Return the values of the first report of a node, from now on, that is accepted."""
        with self._changed:
            self._found.clear()
            assert self._changed.wait_for(lambda: self._accepts(node, accepted), LIMIT_S)
            return self._found[node][1]

    def _accepts(self, node, accepted):
        return node in self._found and accepted(*self._found[node])

    def _receive(self, message):
        with self._changed:
            for status in message.status:
                for node in ("vna_acquisition", "simulator"):
                    if f"/{node}" in status.name:
                        values = {pair.key: pair.value for pair in status.values}
                        self._found[node] = status, values
            self._changed.notify_all()


class VnaAcquisitionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_vna_acquisition")
        cls.services = {}
        for name, service_class in SERVICES.items():
            rospy.wait_for_service(name, LIMIT_S)
            cls.services[name] = rospy.ServiceProxy(name, service_class)
        cls.state = open_shared_state(shared_state_path("/robot1/"))
        cls.reports = Reports()

    def tearDown(self):
        self.fault("none")

    def call(self, name, *arguments):
        return self.services[name](*arguments)

    def succeed(self, name, *arguments):
        answer = self.call(name, *arguments)
        self.assertTrue(answer.success, getattr(answer, "message", ""))
        return answer

    def fault(self, name, count=0):
        return self.succeed("simulator/set_fault", "vna", name, count)

    def set_up_sweep(self):
        self.succeed("connection", True, ADDRESS)
        answer = self.sweep_setup(if_bandwidth_hz=10_000.0, averages=1, output_power="HIGH")
        self.assertTrue(answer.success, answer.message)
        return answer

    def sweep_setup(self, **settings):
        sweep = dict(start_frequency_hz=START_HZ, stop_frequency_hz=STOP_HZ, points=POINTS)
        return self.services["freq_sweep_setup"](FreqSweepSetupRequest(**sweep, **settings))

    def assert_refused(self, answer, fault, *shown):
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault.code, fault.code, answer.message)
        self.assertEqual(message_from(answer).cause, fault)
        for value in shown:
            self.assertIn(str(value), answer.message)

    def test_nothing_works_before_its_time(self):
        self.succeed("connection", False, "")
        values = self.reports.wait("vna_acquisition", lambda _, values: values["address"] == "")
        self.assertEqual(
            received_message("", values["fault"]).cause, faults.NOT_CONNECTED.as_note()
        )
        for name, *arguments in (
            ("get_data", False), ("get_freq",), ("confirm_data", 1), ("get_calibration_status",),
        ):  # fmt: skip
            self.assert_refused(self.call(name, *arguments), faults.NOT_CONNECTED)
        answer = self.call("connection", True, "1.2.3.256")
        self.assert_refused(answer, NOT_ALLOWED, "'1.2.3.256'")
        identity = self.succeed("connection", True, ADDRESS).identity
        self.assertTrue(identity.startswith("Anritsu,MS2026C/2,SIMULATED"), identity)
        self.assert_refused(self.call("get_data", False), faults.NOT_CONNECTED)

    def test_set_up_answers_what_the_instrument_took_and_how_long_a_sweep_takes(self):
        answer = self.set_up_sweep()
        taken = (answer.start_frequency_hz, answer.stop_frequency_hz, answer.points)
        self.assertEqual(taken, (START_HZ, STOP_HZ, POINTS))
        own = (answer.if_bandwidth_hz, answer.averages, answer.output_power)
        self.assertEqual(own, (10_000.0, 1, "HIGH"))
        self.assertGreaterEqual(answer.sweep_duration_s, POINTS * 350e-6)
        self.assertGreater(answer.request_limit_s, REQUEST_TIMEOUT_S)
        calibration = self.succeed("get_calibration_status")
        self.assertTrue(calibration.accepted)
        self.assertEqual(
            (calibration.status, calibration.message, calibration.fault.code),
            (GetCalibrationStatusResponse.HIGH, "HIGH", ""),
        )
        found_hz = list(self.succeed("get_freq").frequency_hz)
        self.assertEqual(found_hz, np.linspace(START_HZ, STOP_HZ, POINTS).tolist())
        data = self.succeed("get_data", False)
        self.assertEqual(len(data.s21_real), POINTS)
        made = (data.if_bandwidth_hz, data.averages, data.output_power)
        self.assertEqual(made, (10_000.0, 1, "HIGH"))
        self.fault("nan")
        self.assert_refused(self.call("get_data", False), VNA_FAILED)

    def test_each_request_gets_one_new_sweep_of_the_place_where_the_carriage_is(self):
        self.set_up_sweep()
        numbers = []
        self.addCleanup(self.state.set_steps, AxisId.Z, 0)
        for x_mm, y_mm, z_steps in ((8, 6, 0), (120, 40, 50), (121, 40, -50)):
            self.state.set_steps(AxisId.X, x_mm * STEPS_PER_MM)
            self.state.set_steps(AxisId.Y, y_mm * STEPS_PER_MM)
            self.state.set_steps(AxisId.Z, z_steps)
            requested = rospy.Time.from_sec(time.time())
            data = self.succeed("get_data", True)
            s21 = np.array(data.s21_real) + 1j * np.array(data.s21_imag)
            self.assertEqual(len(s21), POINTS)
            self.assertEqual({probed_position_mm(one) for one in s21}, {(x_mm, y_mm)})
            turned_deg = probed_rotation_deg(complex(s21[0]))
            self.assertAlmostEqual(turned_deg, z_steps * DEG_PER_STEP, delta=0.4)
            numbers.append(probed_sweep(s21[0]))
            self.assertEqual({probed_sweep(one) for one in s21}, {numbers[-1]})
            self.assertGreaterEqual(data.sweep_started, requested - rospy.Duration(0, 1000))
            took_s = (data.sweep_ended - data.sweep_started).to_sec()
            self.assertGreaterEqual(took_s, POINTS * 350e-6)
            self.succeed("confirm_data", data.number)
        self.assertEqual(numbers, sorted(set(numbers)))
        again = self.call("confirm_data", data.number)
        self.assert_refused(again, CAN_RESUME, data.number)
        self.assertTrue(again.repeat)
        # The probe answers with one large number, which is remarked.
        self.assertGreaterEqual(len(data.quality), 1)
        values = self.reports.wait("vna_acquisition", lambda status, _: status.level == WARN)
        self.assertEqual(received_message("", values["fault"]).fault_code, VNA_DOUBTFUL.code)
        self.assertIn("MS2026C", values["identity"])

    def test_an_analyzer_that_goes_away_is_told_until_it_is_back(self):
        self.set_up_sweep()
        self.fault("link_gone")
        self.reports.wait("simulator", lambda one, _: one.level == WARN and "GONE" in one.message)
        values = self.reports.wait("vna_acquisition", lambda status, _: status.level == ERROR)
        message = received_message("", values["fault"])
        self.assertEqual(message.values["address"], ADDRESS)
        self.assertEqual(values["linked"], "False")
        self.fault("none")
        self.reports.wait("simulator", lambda one, _: one.level == OK and "SIMULA" in one.message)
        self.reports.wait("vna_acquisition", lambda status, _: status.level < ERROR)
        self.succeed("get_data", False)
        values = self.reports.wait("simulator", lambda one, _: True)
        self.assertEqual((values["vna_is_remote"], values["vna_is_continuous"]), ("True", "False"))


if __name__ == "__main__":
    rostest.rosrun("gpr20_vna_acquisition", "test_vna_acquisition", VnaAcquisitionTest)
