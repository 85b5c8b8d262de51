#!/usr/bin/env python3
"""An axis through the real graph: homing, moves, preemption, refusals."""

import statistics
import threading
import time
import unittest

import actionlib
import numpy as np
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from std_srvs.srv import Trigger

from gpr20_msgs.msg import AxisAction, AxisGoal, CurrentCoordinate
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes.axis_id import AxisId

LIMIT_S = 60.0
# So far that a move there is still under way when a slow computer stops it: 9 s.
FAR_MM = 600.0


class Axis:
    """One axis as a client sees it, with the truth beside it."""

    def __init__(self, name):
        self.name = name
        self.client = actionlib.SimpleActionClient(f"{name.value}_axis/axis", AxisAction)
        assert self.client.wait_for_server(rospy.Duration(LIMIT_S))
        rospy.wait_for_service(f"{name.value}_axis/homing", LIMIT_S)
        self.home = rospy.ServiceProxy(f"{name.value}_axis/homing", Trigger)
        self.stop = rospy.ServiceProxy(f"{name.value}_axis/stop", Trigger)
        self._world = open_shared_state(shared_state_path("/"))
        self._changed = threading.Condition()
        self.readings = []
        self._subscriber = rospy.Subscriber(
            f"{name.value}_axis/current_coord", CurrentCoordinate, self._hear
        )

    def _hear(self, message):
        with self._changed:
            self.readings.append(message)
            self._changed.notify_all()

    @property
    def true_steps(self):
        return self._world.steps(self.name)

    def wait_for(self, condition):
        """Wait for a reading that satisfies the condition and return it."""
        with self._changed:
            found = self._changed.wait_for(
                lambda: self.readings and condition(self.readings[-1]), LIMIT_S
            )
            assert found, "no such reading came"
            return self.readings[-1]

    def move(self, target):
        """Move and wait; return (terminal state, result)."""
        self.client.send_goal(AxisGoal(target_coordinate=target))
        return self.finish()

    def begin_move(self, target):
        """Begin a move and return when the axis has moved by some steps."""
        before = self.true_steps
        self.client.send_goal(AxisGoal(target_coordinate=target))
        self.wait_for_motion(before)

    def wait_for_motion(self, before):
        """Wait until the axis is some steps from where it was; readings may still be of before."""
        deadline_s = time.monotonic() + LIMIT_S
        while abs(self.true_steps - before) <= 10:
            assert time.monotonic() < deadline_s, "the axis does not move"
            time.sleep(0.005)

    def finish(self):
        """Wait for the end; return (terminal state, result).

        Not by wait_for_result: SimpleActionClient loses a result that comes before it has kept
        the goal's handle, and would wait for ever.
        """
        deadline_s = time.monotonic() + LIMIT_S
        while self.client.gh.get_comm_state() != actionlib.CommState.DONE:
            assert time.monotonic() < deadline_s, "the goal never ended"
            time.sleep(0.005)
        return self.client.gh.get_goal_status(), self.client.gh.get_result()


class AxisTest(unittest.TestCase):
    """The tests run in the order of their names: the axis is not homed at first."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("axis_rostest")
        cls.x = Axis(AxisId.X)
        cls.z = Axis(AxisId.Z)

    def test_1_a_goal_before_homing_is_aborted_with_the_reason(self):
        state, result = self.x.move(5.0)
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertFalse(result.success)
        self.assertIn("not homed", result.message)
        self.assertEqual(self.x.true_steps, 800)

    def test_2_homing_finds_zero(self):
        response = self.x.home()
        self.assertTrue(response.success, response.message)
        self.assertEqual(self.x.true_steps, 0)
        reading = self.x.wait_for(lambda reading: reading.homed)
        self.assertEqual(reading.coordinate, 0.0)

    def test_3_a_goal_ends_where_it_should(self):
        state, result = self.x.move(12.34)
        self.assertEqual(state, GoalStatus.SUCCEEDED)
        self.assertEqual(result.coordinate, 12.34)
        self.assertEqual(self.x.true_steps, 1234)

    def test_4_goals_outside_the_axis_are_aborted_and_move_nothing(self):
        steps = self.x.true_steps
        for target in (-0.01, 650.5, float("nan"), float("inf")):
            state, result = self.x.move(target)
            self.assertEqual(state, GoalStatus.ABORTED)
            self.assertIn("outside the axis, 0 to 650 mm", result.message)
        self.assertEqual(self.x.true_steps, steps)

    def test_5_a_cancelled_goal_is_preempted_with_an_exact_coordinate(self):
        self.x.move(0.0)
        self.x.begin_move(FAR_MM)
        self.x.client.cancel_goal()
        state, result = self.x.finish()
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.assertFalse(result.success)
        self.assertLess(result.coordinate, FAR_MM)
        self.assertEqual(round(result.coordinate * 100), self.x.true_steps)
        state, result = self.x.move(2.0)
        self.assertEqual((state, self.x.true_steps), (GoalStatus.SUCCEEDED, 200))

    def test_6_a_new_goal_replaces_the_one_under_way(self):
        first = Axis(AxisId.X)
        first.begin_move(FAR_MM)
        state, result = self.x.move(1.0)
        self.assertEqual(state, GoalStatus.SUCCEEDED)
        self.assertEqual(self.x.true_steps, 100)
        self.assertEqual(first.finish()[0], GoalStatus.PREEMPTED)

    def test_7_the_stop_service_ends_a_move_and_a_homing(self):
        self.x.begin_move(FAR_MM)
        self.x.stop()
        state, _result = self.x.finish()
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.x.move(100.0)
        answers = []
        homing = threading.Thread(target=lambda: answers.append(self.x.home()))
        homing.start()
        self.x.wait_for_motion(10000)
        refused_state, refused = self.x.move(1.0)
        self.x.stop()
        homing.join(LIMIT_S)
        self.assertEqual(refused_state, GoalStatus.ABORTED)
        self.assertIn("busy", refused.message)
        self.assertFalse(answers[0].success)
        self.assertIn("stopped", answers[0].message)
        self.assertFalse(self.x.wait_for(lambda reading: not reading.moving).homed)

    def test_8_the_antennas_turn(self):
        self.assertTrue(self.z.home().success)
        for target, steps in ((90.0, 50), (-90.0, -50), (0.0, 0)):
            state, result = self.z.move(target)
            self.assertEqual((state, self.z.true_steps), (GoalStatus.SUCCEEDED, steps))
            self.assertEqual(result.coordinate, target)

    def test_9_the_coordinate_is_published_faster_while_moving(self):
        self.assertTrue(self.x.home().success)
        self.x.readings.clear()
        self.x.client.send_goal(AxisGoal(target_coordinate=100.0))
        self.x.finish()
        stamps = [r.header.stamp.to_sec() for r in self.x.readings if r.moving]
        # 50 Hz, and 10 Hz at rest; the median knows nothing of a computer that stalls.
        self.assertLess(statistics.median(np.diff(stamps)), 0.05)


if __name__ == "__main__":
    rostest.rosrun("gpr20_axis_driver", "axis", AxisTest)
