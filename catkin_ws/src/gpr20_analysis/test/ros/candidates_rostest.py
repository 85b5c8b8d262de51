#!/usr/bin/env python3
"""gpr20 candidates --publish: the list and its markers are there for those who come later."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import rospy
from visualization_msgs.msg import Marker, MarkerArray

from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_msgs.msg import CandidateList
from gpr20_survey.no_clearance import NO_CLEARANCE

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "unit"))
from noise_kit import survey

TIME_LIMIT_S = 60.0
TARGET = (0.11, 0.12, 0.08)


class CandidatesTest(unittest.TestCase):
    def test_list_and_markers_are_published_and_stay(self) -> None:
        folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        data = survey(np.random.default_rng(1), 1.0, [TARGET]).assign_attrs(
            simulated=1, survey_id="published"
        )
        write_dataset(data, folder / "survey.nc")
        command = ["gpr20", "candidates", str(folder / "survey.nc"), "--permittivity", "4"]
        process = subprocess.Popen([*command, "--publish"], stdout=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        found = rospy.wait_for_message("candidates", CandidateList, TIME_LIMIT_S)
        # Latched: it comes to a second subscriber too.
        again = rospy.wait_for_message("candidates", CandidateList, TIME_LIMIT_S)
        markers = rospy.wait_for_message("candidate_markers", MarkerArray, TIME_LIMIT_S).markers
        self.assertEqual(found, again)
        self.assertEqual(found.warning, str(NO_CLEARANCE))
        self.assertEqual((found.survey_id, found.simulated), ("published", True))
        first = found.candidates[0]
        place = (first.x_m, first.y_m, first.depth_m)
        np.testing.assert_allclose(place, TARGET, atol=0.006)
        self.assertEqual(markers[0].action, Marker.DELETEALL)
        self.assertEqual({one.header.frame_id for one in markers}, {"base_link"})
        self.assertEqual(len(markers), 1 + 2 * len(found.candidates))
        self.assertEqual(markers[1].pose.position.z, -first.depth_m)
        self.assertEqual(markers[2].text, f"{first.id} SIMULATED")


if __name__ == "__main__":
    import rostest

    rospy.init_node("candidates_test")
    rostest.rosrun("gpr20_analysis", "candidates", CandidatesTest)
