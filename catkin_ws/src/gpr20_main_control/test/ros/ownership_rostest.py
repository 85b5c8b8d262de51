#!/usr/bin/env python3
"""Others ask for the axes during a survey: goals, homings, zeros, a recording, a frozen control."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import unittest

import actionlib
import rospkg
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE
from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import AxisAction, AxisGoal, ControlStatus, CurrentCoordinate
from gpr20_msgs.srv import Command
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes.axis_id import AxisId

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import LIMIT_S, SurveyClient, json_traces, node_pid

TRACES = 18
CONTROL = "/main_control"
LEASE_LIMIT_S = 2.0
# A ramp at ten times the speed, and what a computer may stall.
REST_S = 4.0
ENDED = (ControlStatus.FINISHED, ControlStatus.PAUSED, ControlStatus.FAILED)
OVER = (ControlStatus.FINISHED, ControlStatus.STOPPED, ControlStatus.FAILED)
# Far enough that the carriage moves for seconds on the way to the next point.
LONG = {"x_start_mm": 10.0, "x_stop_mm": 230.0}


class OwnershipTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("ownership_rostest")
        cls.client = SurveyClient()
        cls.world = open_shared_state(shared_state_path("/"))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def tearDown(self):
        # A test that failed must not be in the way of the next one.
        if self.client.statuses and self.client.statuses[-1].code not in OVER:
            self.client.stop()
            self.client.wait_for_status(*OVER)

    def call(self, axis, service):
        return rospy.ServiceProxy(f"{axis}_axis/{service}", Command)()

    def refused(self, answer):
        """Check that an axis belongs to the main control."""
        self.assertEqual((answer.success, answer.fault_code), (False, "axis.owned"))
        self.assertEqual(message_from(answer).values["owner"], CONTROL)

    def check_right(self, survey_id):
        """Check that the survey is complete, without a pause, and each trace where it says."""
        status = self.client.wait_for_status(*ENDED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        codes = [one.code for one in self.client.statuses]
        self.assertNotIn(ControlStatus.PAUSED, codes)
        stored = json_traces(self.client.folder(survey_id))
        self.assertEqual([one["index"] for one in stored], list(range(TRACES)))
        self.assertEqual(len({tuple(one["zero_epochs"]) for one in stored}), 1)
        found = verify_survey(self.client.folder(survey_id))
        self.assertEqual((found.status, found.unproven), (COMPLETE, 0), found.faults)
        self.check_axes()

    def check_axes(self):
        """Check that each axis is where it says that it is."""
        for axis_id, step in ((AxisId.X, 0.01), (AxisId.Y, 0.01), (AxisId.Z, 1.8)):
            name = f"{axis_id.value}_axis/current_coord"
            reading = rospy.wait_for_message(name, CurrentCoordinate, LIMIT_S)
            self.assertEqual(round(reading.coordinate / step), self.world.steps(axis_id), axis_id)

    def test_1_a_zero_that_is_set_in_a_survey_is_refused(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        for _try in range(5):
            self.refused(self.call("z", "set_zero"))
        self.check_right(survey_id)

    def test_2_foreign_goals_and_homings_are_refused_and_nothing_pauses(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        client = actionlib.SimpleActionClient("x_axis/axis", AxisAction)
        client.wait_for_server()
        results = []
        client.send_goal(
            AxisGoal(target_coordinate=300.0), lambda state, result: results.append((state, result))
        )
        for axis in "xyz":
            self.refused(self.call(axis, "homing"))
        deadline_s = time.monotonic() + LIMIT_S
        while not results and time.monotonic() < deadline_s:
            time.sleep(0.01)
        ((state, result),) = results
        self.assertEqual(state, GoalStatus.REJECTED)
        self.refused(result)
        self.check_right(survey_id)

    def test_3_a_recording_that_is_played_beside_the_robot_does_not_touch_the_survey(self):
        recorded_id = self.client.begin()
        self.client.wait_for_status(ControlStatus.FINISHED)
        recorded = self.client.folder(recorded_id)
        survey_id = self.client.begin()
        self.client.wait_for_visited(2)
        # Everything that it says: results, statuses, goals and coordinates of the axes.
        command = ["rosbag", "play", "--rate", "4", str(recorded / "survey.bag")]
        played = subprocess.Popen(command, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        try:
            own = lambda: [  # noqa: E731
                one for one in self.client.statuses if one.survey_id == survey_id
            ]
            self.client.wait(lambda: own() and own()[-1].code in ENDED)
        finally:
            played.terminate()
            played.wait()
        codes = [one.code for one in own()]
        self.assertEqual(codes[-1], ControlStatus.FINISHED)
        self.assertNotIn(ControlStatus.PAUSED, codes)
        found = verify_survey(self.client.folder(survey_id))
        self.assertEqual((found.status, found.stored), (COMPLETE, TRACES))
        self.check_axes()

    def freeze_in_a_move(self, visited, act):
        """Freeze the control while x moves after so many traces, act, and let it continue.

        Returns:
            How long after it froze x came to rest [s].
        """
        self.client.wait_for_visited(visited)
        while not rospy.wait_for_message("x_axis/current_coord", CurrentCoordinate).moving:
            pass
        pid = node_pid(CONTROL)
        os.kill(pid, signal.SIGSTOP)
        frozen_s = time.monotonic()
        try:
            deadline_s = frozen_s + LIMIT_S
            while rospy.wait_for_message("x_axis/current_coord", CurrentCoordinate).moving:
                self.assertLess(time.monotonic(), deadline_s)
            rested_s = time.monotonic() - frozen_s
            print(f"x came to rest {rested_s:.2f} s after the control froze")
            act()
        finally:
            os.kill(pid, signal.SIGCONT)
        return rested_s

    def test_4_a_frozen_control_leaves_no_moving_robot_and_costs_a_move_but_no_coordinate(self):
        survey_id = self.client.begin(**LONG)
        rested_s = self.freeze_in_a_move(2, lambda: None)
        self.assertLess(rested_s, LEASE_LIMIT_S + REST_S)
        self.client.wait_for_visited(6)
        self.assertNotIn(ControlStatus.PAUSED, [one.code for one in self.client.statuses])
        stored = json_traces(self.client.folder(survey_id))
        self.assertEqual({one["x_coord_mm"] for one in stored}, {10.0, 120.0, 230.0})
        self.assertEqual(len({tuple(one["zero_epochs"]) for one in stored}), 1)
        self.freeze_in_a_move(6, self.set_zero)
        self.check_zero_is_never_forgotten(survey_id)

    def set_zero(self):
        """Set the zero of z as soon as its lease has ended."""
        deadline_s = time.monotonic() + LIMIT_S
        while not self.call("z", "set_zero").success:
            self.assertLess(time.monotonic(), deadline_s)
            time.sleep(0.1)

    def check_zero_is_never_forgotten(self, survey_id):
        # The survey measures a known point again, and asks; nothing is stored meanwhile.
        asked = self.client.wait_for_status(*ENDED)
        self.assertEqual(asked.code, ControlStatus.PAUSED, asked.message)
        self.assertEqual(asked.fault_code, "survey.other_zeros")
        folder = self.client.folder(survey_id)
        stored = json_traces(folder)
        self.assertEqual(len({tuple(one["zero_epochs"]) for one in stored}), 1)
        print(asked.message)
        self.client.forget()
        answer = self.client.resume(survey=survey_id, accept_zeros=True)
        self.assertTrue(answer.success, answer.message)
        status = self.client.wait_for_status(*ENDED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        marked = json_traces(folder)[len(stored) :]
        self.assertTrue(marked)
        for one in marked:
            self.assertTrue(any("not proven" in remark for remark in one["quality"]), one["index"])
        report = json.loads((folder / "survey.json").read_text())["report"]
        self.assertEqual([one["proof"] for one in report["zeros"]], ["start", "accepted"])
        found = verify_survey(folder)
        self.assertEqual(
            (found.unproven, found.verdict.fault_code), (len(marked), "analysis.zeros_unproven")
        )
        self.assertNotEqual(found.status, COMPLETE)


if __name__ == "__main__":
    rostest.rosrun("gpr20_main_control", "ownership", OwnershipTest)
