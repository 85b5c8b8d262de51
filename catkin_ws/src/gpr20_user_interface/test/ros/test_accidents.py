#!/usr/bin/env python3
"""Random touches and stalls of the window after a survey: nothing moves, no record changes.

With real touches of an X server on the whole simulated robot. A third of the touches meet a key
that is seen, so that sheets and pages open; the others land anywhere. Some drag. While the window
is stalled, touches queue up. `GPR20_REAL_TOUCHES` and `GPR20_STALLS` set how many there are.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List, Set, Tuple

import rospy
import rostest
from touched_window import TouchedWindow
from waiting import wait_until

from gpr20_msgs.msg import ControlStatus

TOUCHES = int(os.environ.get("GPR20_REAL_TOUCHES", "150"))
STALLS = int(os.environ.get("GPR20_STALLS", "3"))
SURVEY_LIMIT_S = 120.0
WIDTH_PX, HEIGHT_PX = 800, 480
# Shorter than a hold; the longest ones still open what a long press would.
LONGEST_TAP_S = 0.3
LONGEST_STALL_S = 3.0
LOG = "log.jsonl"
# What touches without a hold may add to the log: a permittivity, markers, a report on a stick.
ADDITIONS = {"decision", "marker", "marker_removed", "export", "audit"}
# Copies of what the log says.
COPIES = {"survey.json", "manifest.json"}
MOVING = {
    ControlStatus.CHECKING,
    ControlStatus.HOMING,
    ControlStatus.SURVEYING,
    ControlStatus.PAUSING,
}


class Accidents(unittest.TestCase):
    def setUp(self) -> None:
        self.data = Path(rospy.get_param("~data"))
        self.draw = random.Random(os.environ.get("GPR20_SEED", "1"))
        self.moves: List[str] = []
        self.codes: List[int] = []
        # By the places of their keys.
        self.screens: Set[Tuple[Tuple[int, int], ...]] = set()
        self._subscribers = [
            rospy.Subscriber("control_status", ControlStatus, self.take_status),
            *(
                rospy.Subscriber(f"{axis}_axis/axis/goal", rospy.AnyMsg, self.note_move, axis)
                for axis in "xyz"
            ),
        ]

    def take_status(self, status: ControlStatus) -> None:
        self.codes.append(status.code)

    def note_move(self, _goal: rospy.AnyMsg, axis: str) -> None:
        self.moves.append(axis)

    def test_random_touches_and_stalls_move_nothing_and_change_no_record(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        window = TouchedWindow(Path(folder.name))
        self.addCleanup(window.close)
        self.survey(window)
        records = self.records()
        self.assertTrue(records)
        self.assertTrue(self.moves, "moves are noticed")
        self.moves.clear()
        self.codes.clear()
        stalled = set(self.draw.sample(range(TOUCHES), min(STALLS, TOUCHES)))
        for number in range(TOUCHES):
            if number in stalled:
                with window.stalled(self.draw.uniform(0.3, LONGEST_STALL_S)):
                    for _ in range(5):
                        self.touch_anywhere(window)
            self.touch(window)
            self.assertEqual(self.moves, [], f"touch {number}")
        self.assertTrue(window.takes_touches("top_bar.stop"))
        # They were no touches of a window that takes none.
        self.assertGreater(len(self.screens), 3)
        self.assertEqual(MOVING.intersection(self.codes), set())
        self.assert_kept(records)

    def survey(self, window: TouchedWindow) -> None:
        wait_until(lambda: window.takes_touches("control.start"), "there is contact")
        window.tap("control.start")
        window.hold("start_sheet.hold")
        first = "result.rows.0.place"
        wait_until(lambda: window.is_shown(first), "the places are shown", limit_s=SURVEY_LIMIT_S)

    def touch(self, window: TouchedWindow) -> None:
        chance = self.draw.random()
        keys = window.find("keys")["keys"] if chance < 0.35 else []
        if keys:
            self.screens.add(tuple(map(tuple, keys)))
            x, y = self.draw.choice(keys)
            window.tap_at(x, y, self.draw.uniform(0.02, LONGEST_TAP_S))
        elif chance < 0.45:
            window.drag(self.place(), self.place())
        else:
            self.touch_anywhere(window)

    def touch_anywhere(self, window: TouchedWindow) -> None:
        window.tap_at(*self.place(), self.draw.uniform(0.02, 0.1))

    def place(self) -> Tuple[int, int]:
        return self.draw.randrange(WIDTH_PX), self.draw.randrange(HEIGHT_PX)

    def records(self) -> Dict[Path, bytes]:
        """Return what is on the disk of the survey: digests, and the log as it is."""
        found = {}
        for path in self.data.rglob("*"):
            if path.is_file() and path.name not in COPIES:
                content = path.read_bytes()
                found[path] = content if path.name == LOG else hashlib.sha256(content).digest()
        return found

    def assert_kept(self, before: Dict[Path, bytes]) -> None:
        after = self.records()
        for path, content in before.items():
            self.assertIn(path, after)
            if path.name != LOG:
                self.assertEqual(after[path], content, path)
                continue
            self.assertTrue(after[path].startswith(content), path)
            added = [json.loads(line) for line in after[path][len(content) :].splitlines()]
            self.assertLessEqual({one["kind"] for one in added}, ADDITIONS)


if __name__ == "__main__":
    rospy.init_node("test_accidents", disable_signals=True)
    rostest.rosrun("gpr20_user_interface", "accidents", Accidents)
