#!/usr/bin/env python3
"""Real touches on a real screen: STOP with a window manager, the main job, accidents.

`GPR20_REAL_TOUCHES` sets the number of random touches; they come at 20 a second.
"""

from __future__ import annotations

import os
import random
import tempfile
import time
import unittest
from pathlib import Path

import rospy
import rostest
from fake_main_control import FakeMainControl
from touched_window import QUIET_S, TouchedWindow
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

    def test_main_job_takes_few_touches(self) -> None:
        window = self.open()
        for name in ("control.tiles.AREA", "text:300 x 300 centre", "text:DONE"):
            window.tap(name)
        address = ("text:192. 168.", "text:1", "text:.", "text:7")
        for name in ("control.tiles.VNA", *address, "text:DONE"):
            window.tap(name)
        self.assert_starts(window, most_touches=20)
        self.fake.pause("waiting for the operator")
        self.assert_stops(window)
        window.close()
        again = self.open()
        again.tap("result.plan")
        self.assert_starts(again, most_touches=10)

    def assert_starts(self, window: TouchedWindow, most_touches: int) -> None:
        starts = self.fake.starts
        window.tap("control.start")
        window.hold("start_sheet.hold")
        wait_until(lambda: self.fake.starts == starts + 1, "the survey starts")
        self.assertLessEqual(window.touches, most_touches)
        parameters = self.fake.parameters
        self.assertEqual(parameters.vna_address, "192.168.1.7")
        self.assertEqual(parameters.x_stop_mm - parameters.x_start_mm, 300.0)
        self.assertEqual(parameters.y_stop_mm - parameters.y_start_mm, 300.0)

    def test_a_bounced_touch_over_a_closing_sheet_does_nothing(self) -> None:
        window = self.open()
        for _ in range(3):
            window.tap("rail.settings")
            place = window.centre("settings.close_button")
            window.tap("settings.close_button")
            for _ in range(3):
                window.tap_at(*place)
            self.assertFalse(window.is_shown("start_sheet"))
            self.assertFalse(window.is_shown("settings"))
            time.sleep(QUIET_S)
        self.assertEqual(self.fake.asked, 0)

    def test_a_double_tap_deletes_no_profile(self) -> None:
        profile = self.folder / "profiles" / "field.yaml"
        profile.parent.mkdir()
        profile.write_text("x_points: 5\n")
        window = self.open()
        window.tap("control.saved")
        time.sleep(QUIET_S)
        names = window.find("profiles.names")
        window.tap_at(names["x"] + 30, names["y"] + 30)
        window.tap("profiles.delete")
        place = window.centre("profiles.delete")
        for _ in range(5):
            window.tap_at(*place, for_s=0.03)
            time.sleep(0.06)
        self.assertTrue(profile.exists())

    def test_random_touches_move_and_delete_nothing(self) -> None:
        profile = self.folder / "profiles" / "field.yaml"
        profile.parent.mkdir()
        profile.write_text("x_points: 5\n")
        window = self.open()
        draw = random.Random(20261122)
        for number in range(RANDOM_TOUCHES):
            begin_s = time.monotonic()
            places = [(draw.randrange(800), draw.randrange(480)) for _ in range(2)]
            if draw.random() < 0.2:
                window.drag(*places)
            else:
                window.tap_at(*places[0], for_s=0.02)
            if number % 50 == 0:
                self.fake.pause("waiting for the operator")
            # Those of xdotool itself are part of the period.
            time.sleep(max(0.0, PERIOD_S - (time.monotonic() - begin_s)))
        self.assertTrue(window.find("window")["window"])
        self.assertEqual((self.fake.asked, self.fake.resumed_with), (0, []))
        self.assertTrue(profile.exists())

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
