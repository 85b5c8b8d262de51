#!/usr/bin/env python3
"""A disk that is full, read-only or slow during a survey: a message, and nothing lost."""

import errno
import os
import shutil
import time
import unittest

import rosbag
import rospy
import rostest
from mcap.reader import make_reader
from survey_client import SurveyClient, json_traces

from gpr20_msgs.msg import ControlStatus

TRACES = 18
SLOW_S = 0.05


class DiskFaultsTest(unittest.TestCase):
    """The faults are switched by a file beside the data folder; see faulty_disk."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("disk_faults_rostest")
        cls.client = SurveyClient()
        cls.fault = cls.client.data.with_name(cls.client.data.name + ".fault")
        cls.client.data.mkdir(parents=True, exist_ok=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data.parent)

    def tearDown(self):
        self.repair()

    def begin_fault(self, kind, value):
        """Switch a fault on in one step: no reader sees half of the file."""
        new = self.fault.with_suffix(".new")
        new.write_text(f"{kind} {value}")
        os.replace(str(new), str(self.fault))

    def repair(self):
        if self.fault.exists():
            self.fault.unlink()

    def test_1_a_full_disk_pauses_the_survey_until_space_was_made(self):
        self.pause_and_go_on(errno.ENOSPC, "disk.full")

    def test_2_a_read_only_disk_pauses_the_survey_until_it_can_be_written(self):
        self.pause_and_go_on(errno.EROFS, "disk.refuses")

    def test_3_a_slow_disk_makes_the_survey_wait(self):
        self.begin_fault("slow", SLOW_S)
        begin_s = time.monotonic()
        survey_id, status = self.client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        # Of each trace at least the file, its folder and both recordings are waited for.
        self.assertGreater(time.monotonic() - begin_s, TRACES * 4 * SLOW_S)
        self.assert_whole(survey_id)

    def test_4_a_survey_does_not_begin_on_a_disk_that_refuses(self):
        self.begin_fault("fail", errno.EROFS)
        before = set(self.client.data.iterdir())
        _, status = self.client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FAILED, status.message)
        self.assertEqual(status.fault_code, "disk.refuses", status.message)
        for folder in set(self.client.data.iterdir()) - before:
            self.assertEqual(list(folder.glob("traces/*")), [])
        self.repair()
        survey_id, status = self.client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        self.assert_whole(survey_id)

    def pause_and_go_on(self, error, code):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        self.begin_fault("fail", error)
        paused = self.client.wait_for_status(ControlStatus.PAUSED)
        self.assertEqual(paused.fault_code, code, paused.message)
        acknowledged = self.client.progress[-1].visited_points
        stored = json_traces(self.client.folder(survey_id))
        self.assertGreaterEqual(len(stored), acknowledged)
        self.assertLess(len(stored), TRACES)

        self.repair()
        self.client.go_on(survey_id)
        status = self.client.wait_for_status(ControlStatus.FINISHED, ControlStatus.PAUSED)
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        self.assert_whole(survey_id)

    def assert_whole(self, survey_id):
        """Every trace is in all three places once, and nothing half is left."""
        folder = self.client.folder(survey_id)
        indices = list(range(TRACES))
        self.assertEqual(sorted(one["index"] for one in json_traces(folder)), indices)
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            in_bag = [one.message.index for one in bag.read_messages("/trace")]
        self.assertEqual(sorted(in_bag), indices)
        with (folder / "survey.mcap").open("rb") as stream:
            statistics = make_reader(stream).get_summary().statistics
            channels = make_reader(stream).get_summary().channels
        (trace,) = [number for number, one in channels.items() if one.topic == "/trace"]
        self.assertEqual(statistics.channel_message_counts[trace], TRACES)
        self.assertEqual([one for one in folder.rglob("*") if one.name.startswith(".")], [])


if __name__ == "__main__":
    rostest.rosrun("gpr20", "disk_faults", DiskFaultsTest)
