#!/usr/bin/env python3
"""The focused image of a survey while it is measured and afterwards, and its export."""

import hashlib
import json
import shutil
import threading
import unittest
import zipfile
from pathlib import Path

import numpy as np
import rospy
import rostest
from survey_client import LIMIT_S, SurveyClient

from gpr20_analysis import verify_survey
from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import read_catalogue
from gpr20_msgs.msg import ControlStatus
from gpr20_msgs.srv import CancelImaging, ExportSurvey, FindCandidates, FocusSurvey, ListVolumes
from gpr20_survey.no_clearance import NO_CLEARANCE

POINTS = 13
AREA = {
    **{"x_start_mm": 80.0, "x_stop_mm": 272.0, "x_points": POINTS},
    **{"y_start_mm": 80.0, "y_stop_mm": 272.0, "y_points": POINTS},
    "frequency_points": 101,
}
TRACES = 2 * POINTS * POINTS
# The sphere of the scene: place and depth [mm], permittivity of the ground.
TARGET_MM, TOP_MM, PERMITTIVITY = (173.3, 181.7), 113.0, 5.0


def levels_of(answer):
    shape = len(answer.depth_mm), len(answer.y_mm), len(answer.x_mm)
    return np.frombuffer(answer.levels_db, "<f4").reshape(shape)


class FocusExportTest(unittest.TestCase):
    """The tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("focus_export_rostest")
        cls.client = SurveyClient()
        cls.stick = Path(rospy.get_param("~stick"))
        services = {
            "focus_survey": FocusSurvey,
            "find_candidates": FindCandidates,
            "cancel_imaging": CancelImaging,
            "with_stick/export_survey": ExportSurvey,
            "with_stick/list_volumes": ListVolumes,
        }
        for name, kind in services.items():
            rospy.wait_for_service(name, LIMIT_S)
            setattr(cls, name.split("/")[-1], staticmethod(rospy.ServiceProxy(name, kind)))
        cls.survey = cls.client.begin(**AREA)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(str(cls.client.data))
        shutil.rmtree(str(cls.stick))

    def test_1_what_is_stored_so_far_is_imaged(self):
        self.client.wait_for_visited(TRACES * 2 // 5)
        answer = self.focus_survey("during", self.survey, PERMITTIVITY)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.survey_id, self.survey)
        self.assertLess(answer.traces, TRACES)
        without_data = np.isnan(levels_of(answer)).all(axis=0)
        measured = int(np.count_nonzero(~without_data))
        self.assertTrue(answer.traces / 2 <= measured <= answer.traces / 2 + 1, measured)
        # Lines are measured in ascending order of Y.
        self.assertFalse(without_data[0].any())
        self.assertTrue(without_data[-1].all())

    def test_2_the_survey_is_not_disturbed(self):
        while self.client.statuses[-1].code != ControlStatus.FINISHED:
            answer = self.focus_survey("again", self.survey, PERMITTIVITY)
            self.assertTrue(answer.success, answer.message)
        codes = {one.code for one in self.client.statuses}
        self.assertNotIn(ControlStatus.PAUSED, codes)

    def test_3_the_whole_image_shows_the_target(self):
        answer = self.focus_survey("after", self.survey, PERMITTIVITY)
        self.assertEqual(answer.traces, TRACES)
        levels_db = levels_of(answer)
        self.assertFalse(np.isnan(levels_db).any())
        deep = np.asarray(answer.depth_mm) > TOP_MM / 2
        layer, row, column = np.unravel_index(np.argmax(levels_db[deep]), levels_db[deep].shape)
        place_mm = answer.x_mm[column], answer.y_mm[row]
        depth_mm = np.asarray(answer.depth_mm)[deep][layer]
        np.testing.assert_allclose(place_mm, TARGET_MM, atol=15.0)
        self.assertAlmostEqual(depth_mm, TOP_MM, delta=25.0)
        found = json.loads(answer.candidates_json)
        self.assertTrue(found["simulated"])
        self.assertEqual(found["warning"], str(NO_CLEARANCE))

    def test_4_candidates_are_found(self):
        answer = self.find_candidates("list", self.survey, PERMITTIVITY, "es")
        self.assertTrue(answer.success, answer.message)
        self.assertTrue(json.loads(answer.candidates_json)["candidates"])

    def test_5_the_survey_goes_to_a_stick(self):
        (volume,) = self.list_volumes().volumes
        self.assertEqual((volume.path, volume.name), (str(self.stick), "STICK"))
        kinds = ["report-html", "candidates-csv", "survey-zip"]
        answer = self.export_survey(
            "export", self.survey, kinds, PERMITTIVITY, "en", str(self.stick)
        )
        self.assertTrue(answer.success, answer.message)
        report, table, whole = (self.stick / name for name in answer.files)
        for path in (report, table):
            text = path.read_text()
            self.assertIn(str(NO_CLEARANCE), text)
            self.assertIn("SIMULATED", text)
        for path in (report, table, whole):
            self.assertIn("SIMULATED", path.name)
            digest = hashlib.sha256(path.read_bytes()).hexdigest()
            self.assertTrue(path.with_name(path.name + ".sha256").read_text().startswith(digest))
        with zipfile.ZipFile(str(whole)) as archive:
            archive.extractall(str(self.stick / "copy"))
        (copy,) = (self.stick / "copy").iterdir()
        self.assertIn("complete and intact", str(verify_survey(copy).verdict))

    def test_5b_without_a_stick_the_answer_has_the_report(self):
        answer = self.export_survey("page", self.survey, ["report-html"], PERMITTIVITY, "es", "")
        self.assertTrue(answer.success, answer.message)
        self.assertIn("SIMULATED_report.html", answer.files[0])
        self.assertIn(read_catalogue(Language.SPANISH).text(NO_CLEARANCE), answer.content.decode())

    def test_6_a_stick_that_is_not_there_is_refused(self):
        answer = self.export_survey("gone", self.survey, ["survey-zip"], 0.0, "en", "/media/gone")
        self.assertFalse(answer.success)
        self.assertIn("not mounted", answer.message)

    def test_7_a_request_is_cancelled(self):
        answers = []
        asking = threading.Thread(
            target=lambda: answers.append(self.find_candidates("slow", self.survey, 0.0, "en"))
        )
        asking.start()
        while not self.cancel_imaging("slow").success and asking.is_alive():
            rospy.sleep(0.01)
        asking.join(LIMIT_S)
        self.assertFalse(answers[0].success)
        self.assertIn("cancelled", answers[0].message)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "focus_export", FocusExportTest)
