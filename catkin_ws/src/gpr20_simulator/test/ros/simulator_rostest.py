#!/usr/bin/env python3
"""The simulator's node: its service, its diagnostics and its instrument, in a namespace."""

import threading
import time
import unittest

import numpy as np
import rospy
import rostest
import vxi11
from diagnostic_msgs.msg import DiagnosticArray

from gpr20_simulator.faults import UNKNOWN_FAULT
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import AdcFault, EndstopFault, open_shared_state
from gpr20_simulator.mid.analyzer.vna_faults import VnaFault
from gpr20_simulator.mid.world.medium import probed_position_mm, probed_rotation_deg, probed_sweep
from gpr20_simulator.srv import SetFault
from gpr20_survey.axes.axis_id import AxisId

LIMIT_S = 60.0
STEPS_PER_MM = 100
DEG_PER_STEP = 1.8


def connected(port):
    """Return a client of the instrument."""
    instrument = vxi11.Instrument("127.0.0.1")
    instrument.client = vxi11.vxi11.CoreClient("127.0.0.1", port)
    return instrument


def control_of(status):
    """Return whether the instrument is remote and whether it sweeps, as the diagnostics say."""
    values = {one.key: one.value for one in status.values}
    return values["vna_is_remote"], values["vna_is_continuous"]


class SimulatorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.wait_for_service("simulator/set_fault", LIMIT_S)
        cls.set_fault = staticmethod(rospy.ServiceProxy("simulator/set_fault", SetFault))
        cls.state = open_shared_state(shared_state_path("/robot1/"))
        cls.instrument = connected(cls.state.vna_port)

    @classmethod
    def tearDownClass(cls):
        cls.instrument.close()

    def tearDown(self):
        for device in ("vna", "endstop_x", "endstop_y", "adc"):
            self.assertTrue(self.set_fault(device, "none", 0).success)

    def wait_for_state(self, condition):
        """Wait for a diagnostic status of the simulator that satisfies the condition."""
        found = threading.Event()

        def receive(message):
            for status in message.status:
                if "simulator" in status.name and condition(status):
                    found.set()

        subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, receive)
        self.assertTrue(found.wait(LIMIT_S))
        subscriber.unregister()

    def swept_values(self):
        """Return the data of one new sweep."""
        self.instrument.write(":INIT:CONT OFF;:SENS:TRACE1:SPAR S21;:FORM REAL,32;:INIT:IMM")
        deadline_s = time.monotonic() + LIMIT_S
        while self.instrument.ask(":STAT:OPER?") != "256":
            self.assertLess(time.monotonic(), deadline_s)
        reply = self.instrument.ask_raw(b":CALC1:DATA? SDAT")
        digits = int(reply[1:2])
        length = int(reply[2 : 2 + digits])
        numbers = np.frombuffer(reply[2 + digits : 2 + digits + length], "<f4")
        return numbers[0::2] + 1j * numbers[1::2]

    def test_the_start_is_that_of_the_scene(self):
        self.assertEqual(self.state.steps(AxisId.Z), 0)
        self.assertIn("SIMULATED", self.instrument.ask("*IDN?"))

    def test_a_sweep_sees_the_carriage_where_the_state_has_it(self):
        numbers = set()
        self.addCleanup(self.state.set_steps, AxisId.Z, 0)
        for x_mm, y_mm, z_steps in ((8, 6, 0), (120, 40, 50), (121, 40, -50)):
            self.state.set_steps(AxisId.X, x_mm * STEPS_PER_MM)
            self.state.set_steps(AxisId.Y, y_mm * STEPS_PER_MM)
            self.state.set_steps(AxisId.Z, z_steps)
            values = self.swept_values()
            self.assertEqual({probed_position_mm(one) for one in values}, {(x_mm, y_mm)})
            (turned_deg,) = {probed_rotation_deg(complex(one)) for one in values}
            self.assertAlmostEqual(turned_deg, z_steps * DEG_PER_STEP, delta=0.4)
            numbers |= {probed_sweep(one) for one in values}
        self.assertEqual(len(numbers), 3)

    def test_a_fault_of_the_instrument_strikes_as_often_as_asked(self):
        answer = self.set_fault("vna", "wrong_identity", 1)
        self.assertTrue(answer.success)
        self.assertIn("SIMULATED", answer.message)
        self.wait_for_state(lambda one: one.level == 1 and b"WRONG" in one.message.encode())
        self.assertNotIn("Anritsu", self.instrument.ask("*IDN?"))
        self.assertIn("Anritsu", self.instrument.ask("*IDN?"))

    def test_a_gone_link_comes_back_after_as_many_seconds_as_counted(self):
        self.assertIn("for 2 s", self.set_fault("vna", "link_gone", 2).message)
        started_s = time.monotonic()
        with self.assertRaises((EOFError, OSError)):
            self.instrument.ask("*IDN?")
        self.wait_for_state(lambda one: one.level == 1 and "LINK_GONE" in one.message)
        self.wait_for_state(lambda one: one.level == 0)
        self.assertGreaterEqual(time.monotonic() - started_s, 2.0)
        type(self).instrument = connected(self.state.vna_port)
        self.assertIn("SIMULATED", self.instrument.ask("*IDN?"))

    def test_every_fault_of_the_instrument_can_be_switched(self):
        for fault in VnaFault:
            if fault is not VnaFault.LINK_GONE:
                self.assertTrue(self.set_fault("vna", fault.value, 0).success)
        self.wait_for_state(lambda one: all(fault in one.message for fault in ("NO_CLEAR", "NAN")))

    def test_diagnostics_show_who_has_control_and_whether_sweeps_run(self):
        self.instrument.write(":INIT:CONT OFF")
        self.wait_for_state(lambda one: control_of(one) == ("True", "False"))
        self.instrument.write(":INIT:CONT ON")
        self.instrument.local()
        self.wait_for_state(lambda one: control_of(one) == ("False", "True"))

    def test_faults_of_other_devices_reach_the_state(self):
        self.assertTrue(self.set_fault("endstop_y", "stuck_closed", 0).success)
        self.assertTrue(self.set_fault("adc", "stuck", 0).success)
        self.assertEqual(self.state.endstop_fault(AxisId.Y), EndstopFault.STUCK_CLOSED)
        self.assertEqual(self.state.endstop_fault(AxisId.X), EndstopFault.NONE)
        self.assertEqual(self.state.adc_fault, AdcFault.STUCK)

    def test_what_does_not_exist_is_refused_with_what_does(self):
        for device, fault, count, part in (
            ("laser", "HANG", 0, "vna, endstop_x, endstop_y, adc"),
            ("vna", "BROKEN", 0, "HANG, DROP"),
            ("vna", "HANG", -5, "-5"),
            ("adc", "STUCK", 1, "count"),
        ):
            answer = self.set_fault(device, fault, count)
            self.assertFalse(answer.success)
            self.assertEqual(answer.fault_code, UNKNOWN_FAULT.code)
            self.assertIn(part, answer.message)

    def test_diagnostics_say_that_it_is_simulated(self):
        self.wait_for_state(lambda one: one.level == 0 and "SIMULATED" in one.message)


if __name__ == "__main__":
    rospy.init_node("simulator_rostest")
    rostest.rosrun("gpr20_simulator", "simulator_test", SimulatorTest)
