#!/usr/bin/env python3
"""An axis through the real graph: its goals, and clients that die.

As a program with arguments it is a client, to be killed in the middle of what it begins:
axis_rostest.py client home | TARGET
"""

import contextlib
import subprocess
import sys
import time
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatus
from actionlib_msgs.msg import GoalStatusArray as Status

from gpr20_common.faults import ASKED_FOR, IN_USE
from gpr20_msgs.msg import AxisAction, AxisActionGoal, AxisActionResult, AxisGoal, CurrentCoordinate
from gpr20_msgs.srv import Command
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes import AxisId

LIMIT_S = 200.0
# So far that a move there is still under way when a slow computer stops it: 9 s.
FAR_MM = 600.0
TOPIC, HOMING = "x_axis/current_coord", "x_axis/homing"


def wait_until(condition):
    """Return once the condition holds."""
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, "the condition never held"
        time.sleep(0.005)


class Axis:
    """The axis as a client sees it, and its true state."""

    def __init__(self):
        self.client = actionlib.SimpleActionClient("x_axis/axis", AxisAction)
        assert self.client.wait_for_server(rospy.Duration(LIMIT_S))
        self.last = rospy.wait_for_message(TOPIC, CurrentCoordinate, LIMIT_S)
        rospy.Subscriber(TOPIC, CurrentCoordinate, lambda message: setattr(self, "last", message))
        # Only now: the first process that opens it sets where the carriage begins.
        self.world = open_shared_state(shared_state_path("/"))

    @property
    def steps(self):
        return self.world.steps(AxisId.X)

    def home(self):
        rospy.wait_for_service(HOMING, LIMIT_S)
        response = rospy.ServiceProxy(HOMING, Command)()
        assert response.success, response.message

    def begin_move(self, target):
        """Begin a move; return when the axis has moved by some steps and the client knows of it."""
        before = self.steps
        self.client.send_goal(AxisGoal(target_coordinate=target))
        wait_until(lambda: abs(self.steps - before) > 10 and self.last.moving)

    def finish(self):
        """Wait for the end; return (terminal state, result).

        Not by wait_for_result: SimpleActionClient loses a result that arrives before it has
        stored the goal's handle, and would wait for ever.
        """
        wait_until(lambda: self.client.gh.get_comm_state() == actionlib.CommState.DONE)
        return self.client.gh.get_goal_status(), self.client.gh.get_result()


@contextlib.contextmanager
def client(what):
    """Let another client begin something, and kill it."""
    process = subprocess.Popen([sys.executable, __file__, "client", what])
    try:
        yield
    finally:
        process.kill()
        process.wait()


class AxisTest(unittest.TestCase):
    """The tests run in the order of their names: the axis is not homed at first."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("axis_rostest")
        cls.x = Axis()

    def assert_at_rest_before(self, target_mm):
        """The axis has come to rest on its way, and its coordinate is exact."""
        wait_until(lambda: not self.x.last.moving and not self.x.last.owner)
        self.assertTrue(0 < self.x.steps < 100 * target_mm)
        if self.x.last.homed:
            self.assertEqual(round(self.x.last.coordinate * 100), self.x.steps)

    def test_1_a_new_goal_replaces_the_one_under_way_and_ends_where_it_should(self):
        self.x.home()
        first = Axis()
        first.begin_move(FAR_MM)
        self.x.begin_move(12.34)
        state, result = self.x.finish()
        self.assertEqual((state, self.x.steps), (GoalStatus.SUCCEEDED, 1234))
        self.assertEqual((result.coordinate, result.zero_epoch), (12.34, self.x.last.zero_epoch))
        state, result = first.finish()
        self.assertEqual((state, result.fault.code), (GoalStatus.PREEMPTED, ASKED_FOR.code))

    def test_2_a_goal_that_was_cancelled_before_it_came_is_answered_with_a_code(self):
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

    def test_3_a_move_and_a_homing_end_when_their_client_is_killed_though_another_one_lives(self):
        with client(str(FAR_MM)):
            wait_until(lambda: self.x.steps > 500 and self.x.last.moving)
        self.assert_at_rest_before(FAR_MM)
        self.assertTrue(self.x.last.homed)
        self.x.begin_move(60.0)
        self.x.finish()
        with client("home"):
            wait_until(lambda: self.x.steps < 5990 and self.x.last.moving)
        self.assert_at_rest_before(60.0)
        self.assertFalse(self.x.last.homed)
        self.x.home()


def main(what):
    rospy.init_node("axis_client", anonymous=True)
    if what == "home":
        # As rosservice does: its connection to the service is all that there is.
        rospy.ServiceProxy(HOMING, Command)()
    else:
        axis = Axis()
        axis.begin_move(float(what))
        axis.finish()


if __name__ == "__main__":
    if sys.argv[1:2] == ["client"]:
        main(sys.argv[2])
    else:
        rostest.rosrun("gpr20_axis_driver", "axis", AxisTest)
