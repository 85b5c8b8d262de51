#!/usr/bin/env python3
"""Another disk in the place of the data folder is refused, and one that fills pauses a survey.

After space was made the survey continues to its end.
"""

import shutil
import subprocess
import unittest

import rosbag
import rospy
import rostest
from survey_client import SurveyClient, json_traces

from gpr20_msgs.msg import ControlStatus

DISK = "size=12m"
TRACES = 18


class FullDiskTest(unittest.TestCase):
    """The data folder becomes a tmpfs after the launch; the tests run in the order of names."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("full_disk_rostest")
        cls.client = SurveyClient()
        cls.client.data.mkdir(exist_ok=True)
        subprocess.run(
            ["mount", "-t", "tmpfs", "-o", DISK, "tmpfs", str(cls.client.data)], check=True
        )

    @classmethod
    def tearDownClass(cls):
        # Lazily: the storage may still be writing its last index.
        subprocess.run(["umount", "--lazy", str(cls.client.data)], check=True)
        shutil.rmtree(cls.client.data)  # what the launch made below

    def fill(self):
        """Leave nothing free on the disk; return the file that takes the space."""
        ballast = self.client.data / "ballast"
        with ballast.open("wb", buffering=0) as file:
            try:
                while True:
                    file.write(b"x" * 4096)
            except OSError:
                return ballast

    def test_0_another_disk_is_refused_until_somebody_accepts_it(self):
        self.assertTrue(self.client.set().success)
        self.client.start()
        failed = self.client.wait_for_status(ControlStatus.FAILED)
        self.assertEqual(failed.fault_code, "storage.other_data_folder", failed.message)
        self.assertEqual(list(self.client.data.iterdir()), [])
        accept = ["rosrun", "gpr20_launch", "robot_config", "accept_data"]
        subprocess.run([*accept, "--data", str(self.client.data)], check=True, timeout=60)

    def test_1_a_survey_that_does_not_fit_is_refused_before_anything_moves(self):
        answer = self.client.set(x_points=100, y_points=100, x_stop_mm=300.0, y_stop_mm=300.0)
        self.assertTrue(answer.success, answer.message)
        self.client.start()
        failed = self.client.wait_for_status(ControlStatus.FAILED)
        self.assertEqual(failed.fault_code, "disk.full", failed.message)
        self.assertEqual(list(self.client.data.glob("*/traces/*")), [])

    def test_2_a_disk_that_fills_pauses_the_survey_and_nothing_is_lost(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        ballast = self.fill()
        paused = self.client.wait_for_status(ControlStatus.PAUSED)
        self.assertEqual(paused.fault_code, "disk.full", paused.message)
        folder = self.client.folder(survey_id)
        stored = json_traces(folder)
        self.assertLess(len(stored), TRACES)
        # Told on another topic than the pause, so perhaps a moment later.
        self.client.wait(lambda: self.client.progress[-1].visited_points == len(stored))

        ballast.unlink()
        self.client.go_on(survey_id)
        status = self.client.wait_for_status(ControlStatus.FINISHED, ControlStatus.PAUSED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        self.assertEqual(len(json_traces(folder)), TRACES)
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            self.assertEqual(bag.get_message_count("/trace"), TRACES)
        partial = [path for path in folder.rglob("*") if path.suffix in (".tmp", ".partial")]
        self.assertEqual(partial, [])
        shutil.rmtree(folder)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "full_disk", FullDiskTest)
