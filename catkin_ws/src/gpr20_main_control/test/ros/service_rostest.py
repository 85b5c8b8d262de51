#!/usr/bin/env python3
"""Maintenance through the graph: homing, jogs, zero, endstops, height, analyzer, and STOP."""

import math
import os
import shutil
import sys
import threading
import time
import unittest

import rospkg
import rospy
import rostest
from std_msgs.msg import Bool

from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.sent_message import message_from
from gpr20_main_control import faults
from gpr20_msgs.msg import ControlStatus, ServiceStatus
from gpr20_msgs.srv import (
    Command,
    DailyCheck,
    DailyCheckRequest,
    GetHeight,
    ServiceMove,
    ServiceMoveRequest,
    TestAnalyzer,
)
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.srv import SetFault
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import CHECK_ORDER

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import LIMIT_S, SurveyClient, wait_until_connected

HOME, JOG, SET_ZERO = ServiceMoveRequest.HOME, ServiceMoveRequest.JOG, ServiceMoveRequest.SET_ZERO
# On a computer that stalls; the jog alone would take longer.
STOP_LIMIT_NS = 2_000_000_000


def wait_until(condition):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, "the condition never held"
        time.sleep(0.005)


class Moving:
    """A service move that is in progress, and its answer."""

    def __init__(self, test, axis, action, distance=0.0):
        self.answer = None
        first = test.state.steps(AxisId(axis))
        self._thread = threading.Thread(target=self._ask, args=(test, axis, action, distance))
        self._thread.start()
        wait_until(lambda: test.state.steps(AxisId(axis)) != first)

    def _ask(self, test, axis, action, distance):
        self.answer = test.move(axis=axis, action=action, distance=distance)

    def join(self):
        self._thread.join(LIMIT_S)
        return self.answer


class ServiceTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("service_rostest")
        cls.client = SurveyClient()
        cls.state = open_shared_state(shared_state_path("/"))
        cls.move = rospy.ServiceProxy("service_move", ServiceMove)
        cls.set_fault = rospy.ServiceProxy("simulator/set_fault", SetFault)
        cls.lamps = {"x": [], "y": []}
        cls.activities = []
        cls.subscribers = [
            rospy.Subscriber(f"{axis}_axis/endstop", Bool, cls.note_lamp, cls.lamps[axis])
            for axis in cls.lamps
        ]
        cls.subscribers.append(
            rospy.Subscriber("service_status", ServiceStatus, cls.activities.append)
        )
        wait_until_connected(cls.subscribers)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    @staticmethod
    def note_lamp(message, lamps):
        lamps.append(message.data)

    def succeed(self, axis, action, distance=0.0):
        answer = self.move(axis=axis, action=action, distance=distance)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(message_from(answer).sentence(), answer.message)
        return answer.message

    def refuse(self, fault, axis, action, distance=0.0):
        steps = self.state.steps(AxisId(axis))
        answer = self.move(axis=axis, action=action, distance=distance)
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault_code, fault.code, answer.message)
        self.assertEqual(self.state.steps(AxisId(axis)), steps)

    def test_01_the_endstops_are_shown_at_rest(self):
        begun_s = time.monotonic()
        self.lamps["x"].clear()
        wait_until(lambda: len(self.lamps["x"]) >= 10)
        self.assertLess(time.monotonic() - begun_s, 2.0)
        self.assertFalse(any(self.lamps["x"]))
        self.set_fault(device="endstop_x", fault="stuck_closed")
        wait_until(lambda: self.lamps["x"][-1])
        self.assertFalse(self.lamps["y"][-1])
        self.set_fault(device="endstop_x", fault="none")
        wait_until(lambda: not self.lamps["x"][-1])

    def test_02_no_axis_is_jogged_before_its_zero_is_known(self):
        self.refuse(faults.SERVICE_HOME_FIRST, "x", JOG, 10.0)
        self.refuse(faults.SERVICE_SET_ZERO, "z", JOG, 10.0)

    def test_03_an_axis_is_homed_and_its_endstop_is_seen_to_close(self):
        self.lamps["x"].clear()
        self.assertIn("The x axis is homed.", self.succeed("x", HOME))
        self.assertEqual(self.state.steps(AxisId.X), 0)
        self.assertIn(True, self.lamps["x"])
        wait_until(lambda: not self.lamps["x"][-1])
        self.assertTrue(self.activities[-2].busy)
        self.assertEqual(self.activities[-2].message, "homing the x axis")
        wait_until(lambda: not self.activities[-1].busy)

    def test_04_jogs_are_bounded_by_the_axis(self):
        self.assertIn("10 mm", self.succeed("x", JOG, 10.0))
        self.assertEqual(self.state.steps(AxisId.X), 1000)
        self.assertIn("0 mm, the end of its range", self.succeed("x", JOG, -100.0))
        self.assertEqual(self.state.steps(AxisId.X), 0)
        self.refuse(faults.SERVICE_END_OF_RANGE, "x", JOG, -1.0)
        for distance in (0.0, math.nan, math.inf, -math.inf):
            self.refuse(faults.SERVICE_VALUE, "x", JOG, distance)

    def test_05_the_zero_of_the_antennas_is_set(self):
        self.refuse(faults.SERVICE_HOME_FIRST, "x", SET_ZERO)
        self.succeed("z", SET_ZERO)
        self.assertIn("10.8 deg", self.succeed("z", JOG, 10.0))
        self.assertEqual(self.state.steps(AxisId.Z), 6)
        self.succeed("z", HOME)
        self.assertEqual(self.state.steps(AxisId.Z), 0)

    def test_06_a_stuck_endstop_is_reported(self):
        self.set_fault(device="endstop_y", fault="stuck_closed")
        answer = self.move(axis="y", action=HOME)
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault_code, "axis.endstop_stuck", answer.message)
        self.assertTrue(self.lamps["y"][-1])
        self.set_fault(device="endstop_y", fault="none")
        self.succeed("y", HOME)

    def test_07_a_start_is_refused_during_a_jog_which_stop_ends(self):
        moving = Moving(self, "x", JOG, 600.0)
        self.assertTrue(self.client.set().success)
        started = self.client.start()
        self.assertFalse(started.success)
        self.assertEqual(started.fault_code, faults.SERVICE_IN_PROGRESS.code)
        self.assertIn("+600", started.message)
        requested_ns = time.monotonic_ns()
        self.assertTrue(self.client.stop().success)
        answer = moving.join()
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault_code, faults.SERVICE_STOPPED.code, answer.message)
        stopping_ns = self.state.last_pulse_ns(AxisId.X) - requested_ns
        rospy.loginfo("last step %.3f s after STOP", 1e-9 * stopping_ns)
        self.assertLess(stopping_ns, STOP_LIMIT_NS)
        self.assertLess(self.state.steps(AxisId.X), 60000)
        self.assertFalse(self.client.stop().success)

    def test_08_a_stop_of_the_axis_itself_ends_a_jog(self):
        self.succeed("x", HOME)
        moving = Moving(self, "x", JOG, 600.0)
        rospy.ServiceProxy("x_axis/stop", Command)()
        answer = moving.join()
        self.assertFalse(answer.success)
        self.assertEqual(answer.fault_code, "survey.move_failed", answer.message)
        self.assertIn("600", answer.message)

    def test_09_a_stop_ends_a_homing(self):
        moving = Moving(self, "x", HOME)
        self.assertTrue(self.client.stop().success)
        self.assertEqual(moving.join().fault_code, faults.SERVICE_STOPPED_UNHOMED.code)
        self.succeed("x", HOME)

    def test_10_the_analyzer_is_tested(self):
        test_analyzer = rospy.ServiceProxy("test_analyzer", TestAnalyzer)
        answer = test_analyzer(address="")
        self.assertTrue(answer.success, answer.message)
        self.assertIn("SIMULATED", answer.identity)
        self.assertEqual((answer.calibration, answer.points), ("HIGH", 51))
        self.assertLess(answer.level_db, 0.0)
        self.assertGreater(answer.sweep_duration_s, 0.0)
        answer = test_analyzer(address="127.0.0.9")
        self.assertFalse(answer.success)
        self.assertEqual(answer.identity, "")

    def test_10_daily_check_takes_its_steps_in_order(self):
        daily_check = rospy.ServiceProxy("daily_check", DailyCheck)
        answer = daily_check(step=DailyCheckRequest.REFLECTOR)
        self.assertEqual((answer.success, answer.fault_code), (False, CHECK_ORDER.code))
        for step in (DailyCheckRequest.EMPTY, DailyCheckRequest.PLATE):
            answer = daily_check(step=step)
            self.assertTrue(answer.success, answer.message)
        answer = daily_check(step=DailyCheckRequest.REFLECTOR)
        self.assertTrue(answer.success, answer.message)
        self.assertFalse(answer.good)
        self.assertIn("No echo of the metal plate", answer.message)
        history = self.client.data / "daily_checks" / "history.jsonl"
        self.assertEqual(len(history.read_text().splitlines()), 1)

    def test_11_the_voltage_of_the_height_sensor_is_known_without_a_height(self):
        get_height = rospy.ServiceProxy("get_height", GetHeight)
        answer = get_height()
        self.assertTrue(answer.success)
        self.assertTrue(0.1 < answer.voltage_v < 3.3)
        self.set_fault(device="adc", fault="out_of_range")
        answer = get_height()
        self.assertFalse(answer.success)
        self.assertTrue(math.isfinite(answer.voltage_v))
        self.assertTrue(math.isnan(answer.height_m))
        self.set_fault(device="adc", fault="none")

    def test_12_a_jog_goes_to_its_end_if_its_client_is_gone(self):
        start = self.state.steps(AxisId.X)
        client = ServiceClient("service_move", ServiceMove)
        with self.assertRaises(ServiceUnavailableError):
            client.call(0.3, axis="x", action=JOG, distance=20.0)
        self.assertLess(self.state.steps(AxisId.X), start + 2000)
        wait_until(lambda: self.state.steps(AxisId.X) == start + 2000)
        wait_until(lambda: not self.activities[-1].busy)

    def test_13_there_is_no_service_during_a_survey(self):
        self.client.begin()
        self.refuse_during_a_survey()
        self.client.wait_for_status(ControlStatus.SURVEYING)
        self.client.wait_for_visited(1)
        self.client.pause()
        self.client.wait_for_status(ControlStatus.PAUSED)
        self.refuse_during_a_survey()
        self.client.stop()
        self.client.wait_for_status(ControlStatus.STOPPED)
        self.succeed("x", JOG, 1.0)

    def refuse_during_a_survey(self):
        for axis, action, distance in (("x", JOG, 1.0), ("y", HOME, 0.0), ("z", SET_ZERO, 0.0)):
            answer = self.move(axis=axis, action=action, distance=distance)
            self.assertFalse(answer.success)
            self.assertEqual(answer.fault_code, faults.SURVEY_IN_PROGRESS.code, answer.message)


if __name__ == "__main__":
    rostest.rosrun("gpr20_main_control", "service", ServiceTest)
