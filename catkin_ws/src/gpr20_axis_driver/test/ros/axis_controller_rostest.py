#!/usr/bin/env python3
"""The axis of the tutorial about controllers, through the real graph: homing, moves, stops."""

import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[4]
sys.path += [str(HERE.parent / "unit"), str(ROOT / "tools/kits")]

from axis_under_test import Axis, wait_until  # noqa: E402
from grbl_board import GrblBoard  # noqa: E402
from tutorial_code import code_blocks  # noqa: E402

from gpr20_axis_driver import faults  # noqa: E402
from gpr20_common.sent_message import message_from  # noqa: E402
from gpr20_msgs.msg import CurrentCoordinate, NodeDescription  # noqa: E402
from gpr20_survey.axes.axis_id import AxisId  # noqa: E402
from gpr20_survey.faults import NOT_HOMED  # noqa: E402

PAGE = ROOT / "docs/extend/axis_controller.md"
AXES = """
x: {{controller: "grbl_axis:GrblController", controller_options: {{host: 127.0.0.1, port: {port}}},
    min_step: 0.0005, max_step: 0.0005, max_coord: 30.0}}
"""
FAR_MM = 29.0


class BoardAxis(Axis):
    """The axis of the simulated board, as a client sees it."""

    def __init__(self, board):
        self.board = board
        self.name, self.group = AxisId.X, "x_axis"
        self.last, self.readings, self.received = None, [], threading.Event()
        self.subscriber = rospy.Subscriber("x_axis/current_coord", CurrentCoordinate, self._receive)
        self.connect()

    @property
    def steps(self):
        return self.board.true_steps


class AxisControllerTest(unittest.TestCase):
    """The tests run in the order of their names: the axis is not homed at first."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("axis_controller_rostest")
        cls.folder = tempfile.TemporaryDirectory()
        folder = Path(cls.folder.name)
        cls.board = GrblBoard()
        for name, code in code_blocks(PAGE, "python").items():
            (folder / name).write_text(code)
        (folder / "axes.yaml").write_text(AXES.format(port=cls.board.port))
        cls.environment = {
            **os.environ,
            "PYTHONPATH": f"{folder}:{os.environ.get('PYTHONPATH', '')}",
        }
        rospy.set_param("/axis_test", cls.check_launch(cls.environment).stdout)
        cls.node = cls.start_node()
        cls.x = BoardAxis(cls.board)

    @classmethod
    def tearDownClass(cls):
        cls.node.terminate()
        cls.node.wait()
        cls.board.close()
        cls.folder.cleanup()

    @classmethod
    def check_launch(cls, environment):
        command = ["rosrun", "gpr20_launch", "check_launch", "--part", "robot", "--robot", "gpr20"]
        return subprocess.run(
            [*command, "--config", cls.folder.name],
            env=environment,
            text=True,
            capture_output=True,
            check=False,
        )

    @classmethod
    def start_node(cls):
        program = HERE.parents[1] / "nodes/axis_driver"
        arguments = ["__ns:=x_axis", "configuration:=/axis_test"]
        return subprocess.Popen([sys.executable, str(program), *arguments], env=cls.environment)

    def test_1_the_launch_is_refused_where_the_package_is_not_installed(self):
        checked = self.check_launch(dict(os.environ))
        self.assertNotEqual(checked.returncode, 0)
        for named in ("x/controller", "grbl_axis:GrblController", "ModuleNotFoundError"):
            self.assertIn(named, checked.stderr)

    def test_2_the_node_says_which_controller_it_has(self):
        topic = "x_axis/axis_driver/description"
        described = rospy.wait_for_message(topic, NodeDescription, 20.0)
        self.assertEqual(described.hardware, "Grbl 1.1h")
        self.assertFalse(described.simulated)
        self.assertIn("grbl_axis:GrblController", described.configuration_json)

    def test_3_a_goal_before_homing_is_aborted(self):
        state, result = self.x.move(5.0)
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertEqual(result.fault_code, NOT_HOMED.code)

    def test_4_homing_and_a_move_end_where_they_should(self):
        self.x.home()
        self.assertEqual(self.x.steps, 0)
        state, result = self.x.move(12.34)
        self.assertEqual((state, result.coordinate), (GoalStatus.SUCCEEDED, 12.34))
        self.assertEqual(self.x.steps, 1234)

    def test_5_goals_outside_the_axis_move_nothing(self):
        for target in (-0.01, 30.5, float("nan")):
            state, result = self.x.move(target)
            self.assertEqual(state, GoalStatus.ABORTED)
            self.assertEqual(result.fault_code, faults.OUTSIDE_TRAVEL.code)
            self.assertIn("30 mm", result.message)
        self.assertEqual(self.x.steps, 1234)

    def test_6_a_cancelled_goal_and_the_stop_service_keep_an_exact_coordinate(self):
        for request in (self.x.client.cancel_goal, lambda: self.x.call("stop")):
            self.x.move(0.0)
            self.x.begin_move(FAR_MM)
            request()
            state, result = self.x.finish()
            self.assertEqual(state, GoalStatus.PREEMPTED)
            self.assertLess(result.coordinate, FAR_MM)
            self.assertEqual(round(result.coordinate * 100), self.x.steps)

    def test_7_a_cable_that_is_pulled_ends_the_move_and_homing_helps(self):
        self.x.move(0.0)
        self.x.begin_move(FAR_MM)
        self.board.unplug()
        state, result = self.x.finish()
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertTrue(message_from(result).may_move)
        wait_until(lambda: not self.x.last.homed)
        self.assertFalse(self.x.call("homing").success)
        self.board.plug_in()
        self.x.home()
        self.assertEqual(self.x.steps, 0)

    def test_8_a_node_that_dies_leaves_the_carriage_at_rest_within_two_seconds(self):
        self.x.begin_move(FAR_MM)
        type(self).node.kill()
        type(self).node.wait()
        killed_s, steps = time.monotonic(), -1
        while steps != self.x.steps:
            self.assertLess(time.monotonic() - killed_s, 3.0)
            steps = self.x.steps
            time.sleep(0.2)
        self.assertLess(steps, FAR_MM * 100)
        type(self).node = self.start_node()
        self.x.connect()
        self.assertFalse(self.x.last.homed)
        self.x.home()
        self.assertEqual(self.x.steps, 0)


if __name__ == "__main__":
    rostest.rosrun("gpr20_axis_driver", "axis_controller", AxisControllerTest)
