#!/usr/bin/env python3
"""From the robot to the image: a survey over three known targets, imaged by `gpr20 image`."""

import json
import math
import shutil
import subprocess
import sys
import unittest

import rospy
import rostest
from survey_client import SurveyClient, described

from gpr20_msgs.msg import ControlStatus
from gpr20_simulator.mid.world.scene import read_scene

SURVEY_LIMIT_S = 200.0
LARGEST_ERROR_MM = 5.0
GRID = {
    "x_start_mm": 60.0,
    "x_stop_mm": 420.0,
    "x_points": 19,
    "y_start_mm": 60.0,
    "y_stop_mm": 420.0,
    "y_points": 19,
    "frequency_points": 101,
}


def gpr20(*arguments):
    """Run the command gpr20 and return what it says."""
    done = subprocess.run(
        [sys.executable, "-m", "gpr20_analysis.commands.main", *map(str, arguments)],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def off_mm(echo, target):
    """Return how far an echo is from a target, across and in depth [mm]."""
    across = math.hypot(echo["x_m"] * 1000.0 - target.x_mm, echo["y_m"] * 1000.0 - target.y_mm)
    return across, (echo["depth_m"] - target.depth_m) * 1000.0


class Imaging(unittest.TestCase):
    """One survey for all tests, which only read it."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("imaging_rostest")
        scene = read_scene(described("simulator")["scene"])
        cls.permittivity = scene.soil.relative_permittivity
        cls.sphere, cls.disc, cls.wire = scene.targets
        cls.report = {}
        cls.client = SurveyClient()
        survey_id = cls.client.begin(permittivity=0.0, **GRID)
        ends = (ControlStatus.FINISHED, ControlStatus.FAILED, ControlStatus.PAUSED)
        cls.client.wait(
            lambda: cls.client.statuses and cls.client.statuses[-1].code in ends, SURVEY_LIMIT_S
        )
        assert cls.client.statuses[-1].code == ControlStatus.FINISHED, cls.client.statuses[-1]
        cls.folder = cls.client.folder(survey_id)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def echoes(self, *options):
        """Return what gpr20 image says as JSON; each image is made once."""
        if options not in self.report:
            self.report[options] = json.loads(gpr20("image", self.folder, "--json", *options))
        return self.report[options]

    def image_at_known_permittivity(self, method):
        return self.echoes("--permittivity", self.permittivity, "--method", method)

    def nearest(self, report, target, rotation_deg):
        """Return the candidate of a polarization that is nearest to a target, and its distances."""
        seen = [one for one in report["candidates"] if rotation_deg in one["rotations_deg"]]
        self.assertTrue(seen, f"no candidate at {rotation_deg} deg")
        found = [(one, *off_mm(one, target)) for one in seen]
        return min(found, key=lambda one: math.hypot(one[1], one[2]))

    def check_point_targets(self, method):
        report = self.image_at_known_permittivity(method)
        for target in (self.sphere, self.disc):
            for rotation_deg in (0.0, 90.0):
                _, across_mm, deeper_mm = self.nearest(report, target, rotation_deg)
                print(
                    f"{method}, {target.name}, {rotation_deg:g} deg: {across_mm:.1f} mm across, "
                    f"{deeper_mm:+.1f} mm in depth"
                )
                self.assertLess(across_mm, LARGEST_ERROR_MM, (method, target.name))
                self.assertLess(abs(deeper_mm), LARGEST_ERROR_MM, (method, target.name))

    def test_phase_shift_finds_point_targets_within_5_mm(self):
        self.check_point_targets("phase-shift")

    def test_back_projection_finds_point_targets_within_5_mm(self):
        self.check_point_targets("back-projection")

    def test_wire_shows_in_the_polarization_along_it_alone(self):
        report = self.image_at_known_permittivity("phase-shift")
        _, _, deeper_mm = self.nearest(report, self.wire, 90.0)
        self.assertLess(abs(deeper_mm), LARGEST_ERROR_MM)
        half_mm = self.wire.size_m * 500.0
        ratios_db = [
            one["polarization_ratio_db"]
            for one in report["candidates"]
            if abs(one["x_m"] * 1000.0 - self.wire.x_mm) < 15.0
            and abs(one["y_m"] * 1000.0 - self.wire.y_mm) < half_mm
            and "sidelobe" not in one["flags"]
        ]
        self.assertTrue(ratios_db)
        self.assertLess(max(ratios_db), -10.0)

    def test_an_assumed_permittivity_says_how_far_off_it_may_be(self):
        report = self.echoes()
        self.assertEqual(report["permittivity_source"], "assumed")
        self.assertLess(report["permittivity_lowest"], self.permittivity)
        self.assertGreater(report["permittivity_highest"], self.permittivity)
        for target in (self.sphere, self.disc):
            _, across_mm, deeper_mm = self.nearest(report, target, 0.0)
            print(
                f"permittivity assumed {report['permittivity']:.2f} instead of "
                f"{self.permittivity:g}: {target.name} {across_mm:.1f} mm across, "
                f"{deeper_mm:+.1f} mm in depth"
            )
            self.assertLess(across_mm, LARGEST_ERROR_MM)
            limit = report["depth_uncertainty"] * target.depth_m * 1000.0 + LARGEST_ERROR_MM
            self.assertLess(abs(deeper_mm), limit)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "survey_to_image", Imaging)
