#!/usr/bin/env python3
"""Axes through the real graph when clients, nodes and the pulses' processes die."""

import os
import signal
import time
import unittest

import rosgraph
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from axis_under_test import LIMIT_S, Axis, exists, killed_client, start_client, wait_until

from gpr20_axis_driver import faults
from gpr20_axis_driver.low.pulse_process import SILENT_PARENT_S
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.ramp import Ramp
from gpr20_survey.faults import NOT_HOMED

X_TIME_SCALE = 10.0
X_STEPS_PER_MM = 100
# What a stop may take besides the ramp, on a computer that stalls; a move to FAR_MM takes 18 s.
STOP_S = 3.0
FAR_MM = 600.0
LEASE_LIMIT_S = 2.0
X_RAMP = Ramp(0.0015, 0.0050, 0.0001)
X_RAMP_S = X_RAMP.duration_s(2 * X_RAMP.braking_steps(X_RAMP.min_pause_s)) / 2 / X_TIME_SCALE
Z_RAMP = Ramp(0.010, 0.025, 0.005)
Z_TIME_SCALE = 0.4
Z_RAMP_S = Z_RAMP.duration_s(2 * Z_RAMP.braking_steps(Z_RAMP.min_pause_s)) / 2 / Z_TIME_SCALE


class AxisFaultsTest(unittest.TestCase):
    """The tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("axis_faults_rostest")
        cls.x = Axis(AxisId.X)
        cls.z = Axis(AxisId.Z)

    def assert_stopped_within(self, axis, requested_ns, ramp_s):
        """The axis is at rest, its last pulse came in time, and its coordinate is exact."""
        wait_until(lambda: axis.last is not None and not axis.last.moving)
        self.assertLess((axis.last_pulse_ns - requested_ns) * 1e-9, ramp_s + STOP_S)
        steps = axis.steps
        axis.received.clear()
        self.assertTrue(axis.received.wait(LIMIT_S))
        self.assertEqual(axis.steps, steps)
        if axis.last.homed:
            step_size = 1.0 / X_STEPS_PER_MM if axis is self.x else 1.8
            self.assertEqual(round(axis.last.coordinate / step_size), steps)

    def test_1_a_move_ends_when_its_client_is_killed_though_another_client_lives(self):
        self.x.home()
        killed_ns = killed_client(self.x, str(FAR_MM), lambda: self.x.steps > 500)
        self.assert_stopped_within(self.x, killed_ns, X_RAMP_S)
        self.assertTrue(self.x.last.homed)
        self.assertLess(self.x.steps, FAR_MM * X_STEPS_PER_MM)
        state, _result = self.x.move(1.0)
        self.assertEqual((state, self.x.steps), (GoalStatus.SUCCEEDED, 100))

    def test_1a_a_move_ends_with_its_ramp_when_its_client_hangs(self):
        client = start_client(self.x, "leased", str(FAR_MM))
        wait_until(lambda: self.x.steps > 500)
        owner = self.x.last.owner
        client.send_signal(signal.SIGSTOP)
        hung_ns = time.monotonic_ns()
        self.assert_stopped_within(self.x, hung_ns, LEASE_LIMIT_S + X_RAMP_S)
        self.assertIn("axis_client", owner)
        wait_until(lambda: not self.x.last.owner)
        self.assertTrue(self.x.last.homed)
        self.assertLess(self.x.steps, FAR_MM * X_STEPS_PER_MM)
        client.kill()
        client.wait()
        self.assertEqual(self.x.move(1.0)[0], GoalStatus.SUCCEEDED)

    def test_2_a_homing_ends_when_its_client_is_killed(self):
        self.x.move(60.0)
        killed_ns = killed_client(self.x, "home", lambda: self.x.steps < 5950)
        self.assert_stopped_within(self.x, killed_ns, 0.0)
        self.assertFalse(self.x.last.homed)
        self.assertGreater(self.x.steps, 0)
        self.x.home()

    def test_3_the_stop_service_and_a_cancelled_goal_end_a_move_in_time(self):
        for request in (lambda: self.x.call("stop"), self.x.client.cancel_goal):
            self.x.begin_move(FAR_MM)
            requested_ns = time.monotonic_ns()
            request()
            self.assertEqual(self.x.finish()[0], GoalStatus.PREEMPTED)
            self.assert_stopped_within(self.x, requested_ns, X_RAMP_S)
            self.x.move(0.0)

    def test_4_a_node_that_is_shut_down_stops_and_leaves_the_pins_low(self):
        self.x.begin_move(FAR_MM)
        pid, pulse_pid = self.x.node_pid, self.x.pulse_pid
        requested_ns = time.monotonic_ns()
        os.kill(pid, signal.SIGINT)
        wait_until(lambda: not exists(pulse_pid))
        self.assertTrue(self.x.pins_low)
        self.assertLess((self.x.last_pulse_ns - requested_ns) * 1e-9, X_RAMP_S + STOP_S)
        wait_until(lambda: not exists(pid))

    def test_5_a_node_that_is_killed_leaves_the_pins_low_and_comes_back_not_homed(self):
        self.x.connect()
        self.x.home()
        self.x.begin_move(FAR_MM)
        pid, pulse_pid = self.x.node_pid, self.x.pulse_pid
        os.kill(pid, signal.SIGKILL)
        killed_ns = time.monotonic_ns()
        wait_until(lambda: not exists(pulse_pid))
        self.assertTrue(self.x.pins_low)
        self.assertLess((self.x.last_pulse_ns - killed_ns) * 1e-9, X_RAMP_S + STOP_S)
        self.x.connect()
        self.assertNotEqual(self.x.node_pid, pid)
        self.assertFalse(self.x.last.homed)
        state, result = self.x.move(1.0)
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertEqual(result.fault_code, NOT_HOMED.code)
        self.x.home()
        self.assertEqual(self.x.steps, 0)

    def test_6_when_the_pulses_process_is_killed_the_goal_is_aborted_and_homing_helps(self):
        self.x.begin_move(FAR_MM)
        pulse_pid = self.x.pulse_pid
        os.kill(pulse_pid, signal.SIGKILL)
        state, result = self.x.finish()
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertEqual(result.fault_code, faults.PULSES_ENDED.code)
        self.assertIn("SIGKILL", result.message)
        self.assertTrue(self.x.pins_low)
        self.assertFalse(exists(pulse_pid))
        wait_until(lambda: not self.x.last.homed)
        self.x.home()
        self.assertEqual(self.x.steps, 0)

    def test_7_a_killed_z_node_knows_its_rotation_again(self):
        self.z.home()
        self.z.begin_move(90.0)
        pid, pulse_pid = self.z.node_pid, self.z.pulse_pid
        os.kill(pid, signal.SIGKILL)
        killed_ns = time.monotonic_ns()
        wait_until(lambda: not exists(pulse_pid))
        self.assertLess((self.z.last_pulse_ns - killed_ns) * 1e-9, Z_RAMP_S + STOP_S)
        self.assertTrue(0 < self.z.steps < 50)
        self.z.connect()
        self.assertFalse(self.z.last.homed)
        self.z.home()
        self.assertEqual(self.z.steps, 0)
        self.assertEqual(self.z.move(-90.0)[1].coordinate, -90.0)
        self.assertEqual(self.z.steps, -50)

    def test_8_a_rotation_that_nobody_knows_must_be_set(self):
        self.z.begin_move(90.0)
        os.kill(self.z.pulse_pid, signal.SIGKILL)
        self.assertEqual(self.z.finish()[0], GoalStatus.ABORTED)
        steps = self.z.steps
        response = self.z.call("homing")
        self.assertFalse(response.success)
        self.assertEqual(response.fault_code, faults.ZERO_UNKNOWN.code)
        self.assertEqual(self.z.steps, steps)
        self.assertTrue(self.z.call("set_zero").success)
        wait_until(lambda: self.z.last.homed)
        self.assertEqual(self.z.last.coordinate, 0.0)
        self.assertEqual(self.z.move(9.0)[0], GoalStatus.SUCCEEDED)
        self.assertEqual(self.z.steps, steps + 5)

    def test_9_only_an_axis_without_endstop_can_be_given_a_zero(self):
        services = rosservice_names()
        self.assertIn("/z_axis/set_zero", services)
        self.assertNotIn("/x_axis/set_zero", services)

    def test_a2_a_node_that_hangs_ends_its_move_and_keeps_an_exact_coordinate(self):
        self.x.begin_move(FAR_MM)
        pid = self.x.node_pid
        os.kill(pid, signal.SIGSTOP)
        hung_ns = time.monotonic_ns()
        try:
            # Longer than a computer may stall, and than the pulses continue without the node.
            wait_until(lambda: time.monotonic_ns() - self.x.last_pulse_ns > 3_000_000_000)
        finally:
            os.kill(pid, signal.SIGCONT)
        self.assertLess((self.x.last_pulse_ns - hung_ns) * 1e-9, SILENT_PARENT_S + STOP_S)
        self.assertLess(self.x.steps, FAR_MM * X_STEPS_PER_MM)
        state, result = self.x.finish()
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertEqual(result.fault_code, faults.DRIVER_HUNG.code)
        wait_until(lambda: round(self.x.last.coordinate * X_STEPS_PER_MM) == self.x.steps)
        self.assertTrue(self.x.last.homed)
        self.assertEqual(self.x.move(1.0)[0], GoalStatus.SUCCEEDED)
        self.assertEqual(self.x.steps, 100)


def rosservice_names():
    _publishers, _subscribers, services = rosgraph.Master(rospy.get_name()).getSystemState()
    return [name for name, _nodes in services]


if __name__ == "__main__":
    rostest.rosrun("gpr20_axis_driver", "axis_faults", AxisFaultsTest)
