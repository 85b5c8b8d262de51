#!/usr/bin/env python3
"""A recorded survey comes back on a graph: by the launch file, and paused, continued and ended."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import rospy

from gpr20_msgs.msg import Replay, Trace
from gpr20_msgs.srv import Command, SetReplayRate

sys.path.append(str(Path(__file__).resolve().parents[5] / "tools/kits"))
sys.path.append(str(Path(__file__).resolve().parents[1] / "unit"))
from survey_kit import POINTS, make_survey, planned_trace

TIME_LIMIT_S = 200.0
NODE = Path(__file__).resolve().parents[2] / "nodes" / "replay"


class ReplayTest(unittest.TestCase):
    def setUp(self) -> None:
        self.data = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.data, ignore_errors=True)
        self.folder = make_survey(self.data, len(POINTS), "finished")
        self.changed = threading.Condition()
        self.traces, self.states = [], []
        for topic, kind, received in (
            ("trace", Trace, self.traces),
            ("replay", Replay, self.states),
        ):
            own = rospy.Subscriber(f"/replay/{topic}", kind, self.take, received)
            self.addCleanup(own.unregister)

    def take(self, message, received) -> None:
        with self.changed:
            received.append(message)
            self.changed.notify_all()

    def wait(self, condition) -> None:
        with self.changed:
            self.assertTrue(self.changed.wait_for(condition, TIME_LIMIT_S))

    def assert_all_came(self) -> None:
        self.wait(lambda: len(self.traces) >= len(POINTS))
        for index, message in enumerate(self.traces):
            self.assertEqual(message.index, index)
            self.assertEqual(list(message.s21_real), planned_trace(index).s21_real.tolist())
        self.assertEqual(len(self.traces), len(POINTS))

    def test_the_launch_file_replays_a_folder_named_from_where_it_is_called(self) -> None:
        named = self.data / 'a "survey" of señor O\'Neill & <sons> $HOME'
        self.folder.rename(named)
        command = ["roslaunch", "gpr20", "replay.launch", f"survey:={named.name}", "rate:=100"]
        subprocess.run(
            command, check=True, timeout=TIME_LIMIT_S, stdout=subprocess.DEVNULL, cwd=self.data
        )
        self.assert_all_came()

    def test_it_is_paused_continued_and_ended_and_a_second_one_is_refused(self) -> None:
        command = [sys.executable, str(NODE), str(self.folder)]
        first = subprocess.Popen([*command, "--paused", "--hold"], stdout=subprocess.DEVNULL)
        self.addCleanup(first.wait)
        self.addCleanup(first.kill)
        self.wait(lambda: self.states and self.states[-1].state == Replay.PAUSED)
        for name, kind, values in (("set_rate", SetReplayRate, [100.0]), ("continue", Command, [])):
            rospy.wait_for_service(f"/replay/{name}", TIME_LIMIT_S)
            self.assertTrue(rospy.ServiceProxy(f"/replay/{name}", kind)(*values).success)
        self.wait(lambda: self.states[-1].state == Replay.ENDED)
        self.assert_all_came()
        done = subprocess.run(command, timeout=TIME_LIMIT_S, capture_output=True, text=True)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIsNone(first.poll())


if __name__ == "__main__":
    import rostest

    rospy.init_node("replay_test")
    rostest.rosrun("gpr20_analysis", "replay_survey", ReplayTest)
