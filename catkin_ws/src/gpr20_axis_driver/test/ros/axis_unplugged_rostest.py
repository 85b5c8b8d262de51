#!/usr/bin/env python3
"""An axis whose client's network cable is pulled, and plugged in again."""

import time
import unittest

import rospy
import rostest
from axis_under_test import LIMIT_S, Axis, start_client, wait_until

from gpr20_axis_driver.high.goals import SILENCE_LIMIT_S
from gpr20_survey.axes.axis_id import AxisId

# What a stop may take on a computer that stalls; a move to FAR_MM takes 18 s.
STOP_S = 3.0
FAR_MM = 600.0
X_STEPS_PER_MM = 100


class AxisUnpluggedTest(unittest.TestCase):
    def test_a_move_ends_when_its_client_vanishes_without_a_word_and_the_next_one_arrives(self):
        x = Axis(AxisId.X)
        x.home()
        client = start_client(x, str(FAR_MM), "unplugged")
        wait_until(lambda: x.steps > 500)
        unplugged_ns = time.monotonic_ns()
        client.stdin.write(b"\n")
        client.stdin.flush()
        wait_until(lambda: not x.last.moving)
        # Probed every second, and some seconds for a computer that does too much else.
        self.assertLess((x.last_pulse_ns - unplugged_ns) * 1e-9, SILENCE_LIMIT_S + STOP_S)
        self.assertLess(x.steps, FAR_MM * X_STEPS_PER_MM)
        self.assertTrue(x.last.homed)
        # The cable is plugged in again: the same connection carries the client's next goal.
        client.communicate(b"\n", timeout=LIMIT_S)
        self.assertEqual(client.returncode, 0)
        self.assertEqual(x.steps, 100)


if __name__ == "__main__":
    rospy.init_node("axis_unplugged_rostest")
    rostest.rosrun("gpr20_axis_driver", "axis_unplugged", AxisUnpluggedTest)
