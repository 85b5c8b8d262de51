#!/usr/bin/env python3
"""An axis through the real graph: homing, moves, preemption, refusals."""

import statistics
import threading
import unittest

import numpy as np
import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from axis_under_test import LIMIT_S, Axis, start_client, wait_until
from diagnostic_msgs.msg import DiagnosticArray

from gpr20_axis_driver import faults
from gpr20_axis_driver.high.goals import LISTED_GOALS
from gpr20_common.message import Severity
from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import AxisActionGoal, AxisActionResult
from gpr20_msgs.srv import AxisLease
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import NOT_HOMED

# So far that a move there is still under way when a slow computer stops it: 9 s.
FAR_MM = 600.0


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
        self.assertEqual(result.fault_code, NOT_HOMED.code)
        self.assertEqual(self.x.steps, 800)
        # The diagnostics name the same fault, as a warning.
        wait_until(lambda: self.fault_in_diagnostics("/x_axis/axis_driver") == NOT_HOMED.code)

    @staticmethod
    def fault_in_diagnostics(node):
        for status in rospy.wait_for_message("/diagnostics", DiagnosticArray, LIMIT_S).status:
            if status.name.startswith(node.lstrip("/")):
                return {one.key: one.value for one in status.values}["fault_code"]
        return None

    def test_2_homing_finds_zero(self):
        self.x.home()
        self.assertEqual(self.x.steps, 0)
        wait_until(lambda: self.x.last.homed)
        self.assertEqual(self.x.last.coordinate, 0.0)

    def test_3_a_goal_ends_where_it_should(self):
        state, result = self.x.move(12.34)
        self.assertEqual(state, GoalStatus.SUCCEEDED)
        self.assertEqual(result.coordinate, 12.34)
        self.assertEqual(self.x.steps, 1234)

    def test_4_goals_outside_the_axis_are_aborted_and_move_nothing(self):
        steps = self.x.steps
        for target in (-0.01, 650.5, float("nan"), float("inf")):
            state, result = self.x.move(target)
            self.assertEqual(state, GoalStatus.ABORTED)
            self.assertEqual(result.fault_code, faults.OUTSIDE_TRAVEL.code)
            message = message_from(result)
            self.assertEqual(message.fault_code, result.fault_code)
            self.assertEqual((message.values["low"], message.values["high"]), (0.0, 650.0))
        self.assertEqual(self.x.steps, steps)

    def test_5_a_cancelled_goal_is_preempted_with_an_exact_coordinate(self):
        self.x.move(0.0)
        self.x.begin_move(FAR_MM)
        self.x.client.cancel_goal()
        state, result = self.x.finish()
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.assertFalse(result.success)
        self.assertLess(result.coordinate, FAR_MM)
        self.assertEqual(round(result.coordinate * 100), self.x.steps)
        state, result = self.x.move(2.0)
        self.assertEqual((state, self.x.steps), (GoalStatus.SUCCEEDED, 200))

    def test_6_a_new_goal_replaces_the_one_under_way(self):
        first = Axis(AxisId.X)
        first.begin_move(FAR_MM)
        state, _result = self.x.move(1.0)
        self.assertEqual(state, GoalStatus.SUCCEEDED)
        self.assertEqual(self.x.steps, 100)
        state, result = first.finish()
        self.assertEqual((state, result.fault_code), (GoalStatus.PREEMPTED, faults.STOPPED.code))

    def test_6a_a_goal_that_was_cancelled_before_it_came_is_answered_with_a_code(self):
        statuses, results = [], []
        goals = rospy.Publisher("x_axis/axis/goal", AxisActionGoal, queue_size=1)
        cancels = rospy.Publisher("x_axis/axis/cancel", GoalID, queue_size=1)
        subscribers = [
            rospy.Subscriber("x_axis/axis/status", GoalStatusArray, statuses.append),
            rospy.Subscriber("x_axis/axis/result", AxisActionResult, results.append),
        ]
        wait_until(lambda: goals.get_num_connections() and cancels.get_num_connections())
        goal_id = GoalID(id="cancelled")
        cancels.publish(goal_id)
        wait_until(
            lambda: any(
                one.goal_id.id == goal_id.id for array in statuses for one in array.status_list
            )
        )
        goals.publish(AxisActionGoal(goal_id=goal_id))
        wait_until(lambda: results)
        self.assertFalse(results[0].result.success)
        self.assertEqual(results[0].result.fault_code, faults.NOT_BEGUN.code)
        self.assertTrue(results[0].result.message)
        for subscriber in subscribers:
            subscriber.unregister()

    def test_7_the_stop_service_ends_a_move_and_a_homing(self):
        self.x.begin_move(FAR_MM)
        self.x.call("stop")
        state, _result = self.x.finish()
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.x.move(100.0)
        answers = []
        homing = threading.Thread(target=lambda: answers.append(self.x.call("homing")))
        homing.start()
        wait_until(lambda: self.x.steps < 9990)
        refused_state, refused = self.x.move(1.0)
        self.x.call("stop")
        homing.join(LIMIT_S)
        self.assertEqual(refused_state, GoalStatus.ABORTED)
        self.assertEqual(refused.fault_code, faults.BUSY.code)
        self.assertFalse(answers[0].success)
        self.assertEqual(answers[0].fault_code, faults.STOPPED.code)
        self.assertIs(message_from(answers[0]).cause.severity, Severity.NOTE)
        wait_until(lambda: not self.x.last.moving)
        self.assertFalse(self.x.last.homed)
        # Nothing is wrong with an axis whose homing somebody has ended.
        wait_until(lambda: self.fault_in_diagnostics("/x_axis/axis_driver") == NOT_HOMED.code)

    def test_8_the_antennas_turn(self):
        self.z.home()
        for target, steps in ((90.0, 50), (-90.0, -50), (0.0, 0)):
            state, result = self.z.move(target)
            self.assertEqual((state, self.z.steps), (GoalStatus.SUCCEEDED, steps))
            self.assertEqual(result.coordinate, target)

    def test_9_the_coordinate_is_published_faster_while_moving(self):
        self.x.home()
        self.x.readings.clear()
        self.x.move(100.0)
        stamps = [r.header.stamp.to_sec() for r in self.x.readings if r.moving]
        # 50 Hz, and 10 Hz at rest; the median ignores a computer that stalls.
        self.assertLess(statistics.median(np.diff(stamps)), 0.05)
        for _period in ("soon after the move", "long after it"):
            self.x.readings.clear()
            wait_until(lambda: len(self.x.readings) > 15)
            stamps = [r.header.stamp.to_sec() for r in self.x.readings]
            self.assertAlmostEqual(statistics.median(np.diff(stamps)), 0.1, delta=0.04)

    def test_while_a_node_has_the_axes_nobody_else_moves_them_or_sets_their_zero(self):
        self.x.home()
        self.z.home()
        self.x.move(1.0)
        before = (self.x.last_zero, self.z.last_zero, self.x.steps)
        clients = [start_client(axis, "leased") for axis in (self.x, self.z)]
        try:
            wait_until(lambda: all("axis_client" in one.last.owner for one in (self.x, self.z)))
            owner = self.x.last.owner
            state, result = self.x.move(50.0)
            self.assertEqual((state, result.fault_code), (GoalStatus.REJECTED, "axis.owned"))
            self.assertEqual(message_from(result).values["owner"], owner)
            for axis, service in ((self.x, "homing"), (self.z, "homing"), (self.z, "set_zero")):
                answer = axis.call(service)
                self.assertEqual((answer.success, answer.fault_code), (False, "axis.owned"))
                self.assertEqual(message_from(answer).values["owner"], axis.last.owner)
            lease = rospy.ServiceProxy("x_axis/lease", AxisLease)()
            self.assertEqual((lease.success, lease.fault_code), (False, "axis.owned"))
            self.assertTrue(self.x.call("stop").success)
        finally:
            for client in clients:
                client.kill()
                client.wait()
        self.assertEqual((self.x.last_zero, self.z.last_zero, self.x.steps), before)
        # A holder that died cannot renew: the axes are free again.
        wait_until(lambda: not self.x.last.owner and not self.z.last.owner)
        state, result = self.x.move(2.0)
        self.assertEqual(state, GoalStatus.SUCCEEDED)

    def test_while_nobody_has_the_axis_its_owner_is_who_moves_it(self):
        self.x.home()
        self.x.begin_move(FAR_MM)
        wait_until(lambda: self.x.last.moving)
        self.assertEqual(self.x.last.owner, rospy.get_name())
        refused = start_client(self.x, "home")
        self.assertEqual(refused.wait(LIMIT_S), 0)
        self.assertTrue(self.x.last.moving and self.x.last.homed)
        self.x.call("stop")
        self.x.finish()
        wait_until(lambda: not self.x.last.owner)

    def test_each_homing_and_set_zero_is_another_zero_and_results_name_it(self):
        zeros = []
        for begin in (self.z.home, lambda: self.z.call("set_zero"), self.z.home):
            begin()
            zeros.append(self.z.last_zero)
        first = zeros[0]
        self.assertEqual([number for number, _time in zeros], [first[0] + n for n in range(3)])
        self.assertEqual(sorted(zeros), zeros)
        _state, result = self.z.move(1.8)
        self.assertEqual((result.zero_epoch, result.zero_time.to_nsec()), zeros[-1])

    def test_goals_that_ended_do_not_fill_the_status(self):
        statuses = []
        self.x.home()
        status = rospy.Subscriber("x_axis/axis/status", GoalStatusArray, statuses.append)
        for target in np.arange(1, 31) * 0.1:
            state, _result = self.x.move(target)
            self.assertEqual(state, GoalStatus.SUCCEEDED)
        wait_until(lambda: statuses and statuses[-1].status_list)
        # Those that are kept, and the one under way.
        self.assertLessEqual(max(len(one.status_list) for one in statuses), LISTED_GOALS + 2)
        status.unregister()


if __name__ == "__main__":
    rostest.rosrun("gpr20_axis_driver", "axis", AxisTest)
