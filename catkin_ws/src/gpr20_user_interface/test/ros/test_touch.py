#!/usr/bin/env python3
"""Real touches on a real screen: STOP with a window manager, the main job, accidents.

`GPR20_REAL_TOUCHES` sets the number of random touches; they come at 20 a second.
"""

from __future__ import annotations

import os
import tempfile
import unittest
from pathlib import Path

import rospy
import rostest
from fake_main_control import FakeMainControl
from touched_window import TouchedWindow
from waiting import wait_until

SIZES = ("480x320", "800x480", "1280x800")
RANDOM_TOUCHES = int(os.environ.get("GPR20_REAL_TOUCHES", "100"))
PERIOD_S = 0.05


class Touch(unittest.TestCase):
    def setUp(self) -> None:
        self.fake = FakeMainControl("")
        self.addCleanup(self.fake.close)
        self.fake.describe_robot()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def open(self, size: str = "800x480", **options: bool) -> TouchedWindow:
        window = TouchedWindow(self.folder, size, **options)
        self.addCleanup(window.close)
        return window

    def assert_stops(self, window: TouchedWindow) -> None:
        self.fake.pause("waiting for the operator")
        stops = self.fake.stops
        window.tap("top_bar.stop")
        wait_until(lambda: self.fake.stops == stops + 1, "STOP acts")

    def test_full_screen_leaves_no_room_for_a_frame(self) -> None:
        for size, managed in (*((size, True) for size in SIZES), ("800x480", False)):
            with self.subTest(size=size, managed=managed):
                window = self.open(size, full_screen=True, managed=managed)
                self.assert_covers(window, size)
                self.assert_stops(window)
                window.close()

    def test_a_window_with_its_frame_fits_on_the_screen(self) -> None:
        for size in SIZES:
            with self.subTest(size=size):
                window = self.open(size, full_screen=False)
                self.wait_until_it_fits(window)
                known = window.find("window")
                self.assertNotEqual(known["frame"], known["window"], "there is no frame")
                if size == "1280x800":
                    self.assertEqual(known["window"][2:], [800, 480])
                self.assertEqual(known["outside"], [])
                self.assert_stops(window)
                window.close()

    def assert_covers(self, window: TouchedWindow, size: str) -> None:
        whole = [0, 0, *(int(side) for side in size.split("x"))]
        wait_until(lambda: window.find("window")["window"] == whole, f"it covers {size}")
        known = window.find("window")
        self.assertEqual(known["frame"], whole)
        self.assertEqual(known["outside"], [])

    def wait_until_it_fits(self, window: TouchedWindow) -> None:
        wait_until(lambda: self.fits(window), "the frame is on the screen")

    def fits(self, window: TouchedWindow) -> bool:
        known = window.find("window")
        left, top, width, height = known["frame"]
        _, _, screen_width, screen_height = known["screen"]
        inside = left >= 0 and top >= 0 and left + width <= screen_width
        return inside and top + height <= screen_height and known["frame"] != known["window"]


if __name__ == "__main__":
    rospy.init_node("test_touch", disable_signals=True)
    rostest.rosrun("gpr20_user_interface", "touch", Touch)
