#!/usr/bin/env python3
"""Axes through the real graph: goals, STOP, owners, and clients that die."""

import socket
import threading
import unittest

import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatus
from actionlib_msgs.msg import GoalStatusArray as Status
from axis_under_test import LIMIT_S, Axis, end_client, start_client, vanish, wait_until

from gpr20_common.faults import ASKED_FOR, IN_USE
from gpr20_common.high.answers import message_from
from gpr20_msgs.msg import AxisActionGoal, AxisActionResult
from gpr20_survey.axes.axis_id import AxisId

# So far that a move there is still under way when a slow computer stops it: 9 s.
FAR_MM = 600.0
REFUSED = (GoalStatus.REJECTED, IN_USE.code)


class AxisTest(unittest.TestCase):
    """The tests run in the order of their names: the axis is not homed at first."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("axis_rostest")
        cls.x, cls.z = Axis(AxisId.X), Axis(AxisId.Z)

    def assert_at_rest_before(self, target_mm):
        """The axis has come to rest on its way, and its coordinate is exact."""
        wait_until(lambda: not self.x.last.moving and not self.x.last.owner)
        self.assertTrue(0 < self.x.steps < 100 * target_mm)
        if self.x.last.homed:
            self.assertEqual(round(self.x.last.coordinate * 100), self.x.steps)

    def test_2_homing_finds_zero_and_goals_end_where_they_should(self):
        self.x.home()
        self.z.home()
        self.assertEqual(self.x.steps, 0)
        for axis, target, steps in (
            (self.x, 12.34, 1234), (self.z, 90.0, 50), (self.z, -90.0, -50), (self.z, 0.0, 0),
        ):  # fmt: skip
            state, result = axis.move(target)
            self.assertEqual((state, axis.steps), (GoalStatus.SUCCEEDED, steps))
            self.assertEqual(result.coordinate, target)
            self.assertEqual(result.zero_epoch, axis.last.zero_epoch)

    def test_5_a_cancelled_goal_is_preempted_with_an_exact_coordinate(self):
        self.x.begin_move(FAR_MM)
        self.x.client.cancel_goal()
        state, result = self.x.finish()
        self.assertEqual((state, result.fault.code), (GoalStatus.PREEMPTED, ASKED_FOR.code))
        self.assertEqual(round(result.coordinate * 100), self.x.steps)
        self.assert_at_rest_before(FAR_MM)

    def test_6_a_new_goal_replaces_the_one_under_way(self):
        first = Axis(AxisId.X)
        first.begin_move(FAR_MM)
        state, _result = self.x.move(1.0)
        self.assertEqual((state, self.x.steps), (GoalStatus.SUCCEEDED, 100))
        state, result = first.finish()
        self.assertEqual((state, result.fault.code), (GoalStatus.PREEMPTED, ASKED_FOR.code))

    def test_6a_a_goal_that_was_cancelled_before_it_came_is_answered_with_a_code(self):
        results = []
        goals = rospy.Publisher("x_axis/axis/goal", AxisActionGoal, queue_size=1)
        cancels = rospy.Publisher("x_axis/axis/cancel", GoalID, queue_size=1)
        rospy.Subscriber("x_axis/axis/result", AxisActionResult, results.append)
        wait_until(lambda: goals.get_num_connections() and cancels.get_num_connections())
        cancels.publish(GoalID(id="cancelled"))
        wait_until(lambda: "cancelled" in str(rospy.wait_for_message("x_axis/axis/status", Status)))
        goals.publish(AxisActionGoal(goal_id=GoalID(id="cancelled")))
        wait_until(lambda: any(one.status.goal_id.id == "cancelled" for one in results))
        self.assertEqual(results[-1].result.fault.code, IN_USE.code)

    def test_7_the_stop_service_ends_a_move_and_a_homing(self):
        self.x.begin_move(FAR_MM)
        self.x.call("stop")
        self.assertEqual(self.x.finish()[0], GoalStatus.PREEMPTED)
        self.assert_at_rest_before(FAR_MM)
        answers, steps = [], self.x.steps
        homing = threading.Thread(target=lambda: answers.append(self.x.call("homing")))
        homing.start()
        wait_until(lambda: self.x.steps < steps - 10)
        refused_state, refused = self.x.move(1.0)
        self.x.call("stop")
        homing.join(LIMIT_S)
        self.assertEqual((refused_state, refused.fault.code), (GoalStatus.ABORTED, "robot.in_use"))
        self.assertEqual(answers[0].fault.code, ASKED_FOR.code)
        self.assert_at_rest_before(FAR_MM)
        self.assertFalse(self.x.last.homed)
        self.x.home()

    def test_8_while_another_node_has_the_axes_nobody_else_moves_them_or_sets_their_zero(self):
        steps, zero = self.x.steps, self.z.last.zero_epoch
        clients = [start_client(axis, "leased") for axis in (self.x, self.z)]
        try:
            wait_until(lambda: all("axis_client" in one.last.owner for one in (self.x, self.z)))
            state, result = self.x.move(50.0)
            self.assertEqual((state, result.fault.code), REFUSED)
            self.assertEqual(message_from(result).values["owner"], self.x.last.owner)
            for axis, service in ((self.x, "homing"), (self.z, "set_zero")):
                self.assertEqual(axis.call(service).fault.code, IN_USE.code)
            self.assertTrue(self.x.call("stop").success)
        finally:
            for client in clients:
                end_client(client)
        # A holder that died cannot renew: the axes are free again.
        wait_until(lambda: not self.x.last.owner and not self.z.last.owner)
        self.assertEqual((self.x.steps, self.z.last.zero_epoch), (steps, zero))

    def test_9_a_move_and_a_homing_end_when_their_client_is_killed_though_another_one_lives(self):
        client = start_client(self.x, str(FAR_MM))
        wait_until(lambda: self.x.steps > 500 and self.x.last.moving)
        end_client(client)
        self.assert_at_rest_before(FAR_MM)
        self.assertTrue(self.x.last.homed)
        self.x.move(60.0)
        client = start_client(self.x, "home")
        wait_until(lambda: self.x.steps < 5990 and self.x.last.moving)
        end_client(client)
        self.assert_at_rest_before(60.0)
        self.assertFalse(self.x.last.homed)
        self.x.home()

    def test_a_move_ends_when_its_client_vanishes_without_a_word_and_the_next_one_arrives(self):
        with socket.socket() as unused:
            try:
                vanish(unused)
            except OSError as error:
                self.skipTest(f"no filter can be put on a socket: {error}")
        client = start_client(self.x, str(FAR_MM), "unplugged")
        wait_until(lambda: self.x.steps > 500 and self.x.last.moving)
        client.stdin.write(b"\n")
        client.stdin.flush()
        self.assert_at_rest_before(FAR_MM)
        self.assertTrue(self.x.last.homed)
        # The cable is plugged in again: the same connection carries the client's next goal.
        client.communicate(b"\n", timeout=LIMIT_S)
        self.assertEqual((client.returncode, self.x.steps), (0, 100))


if __name__ == "__main__":
    rostest.rosrun("gpr20_axis_driver", "axis", AxisTest)
