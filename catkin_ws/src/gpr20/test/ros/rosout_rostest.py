#!/usr/bin/env python3
"""The log of all nodes, in the file and on the topic."""

from __future__ import annotations

import queue
import time
import unittest
from pathlib import Path

import rospkg
import rospy
import rostest
from rosgraph_msgs.msg import Log

LIMIT_S = 20.0
POLL_S = 0.05


def log_file():
    """Return the file in which this run's log is kept."""
    return Path(rospkg.get_log_dir()) / rospy.get_param("/run_id") / "rosout.log"


def entry(level, text):
    """Return an entry of a node at a place and a time."""
    message = Log(level=level, name="/x_axis/axis_driver", msg=text)
    message.header.stamp = rospy.Time(12, 500_000_000)
    message.file, message.line, message.function = "axis.py", 7, "home"
    return message


class RosoutTest(unittest.TestCase):
    """What is published on /rosout."""

    @classmethod
    def setUpClass(cls):
        cls.aggregated = queue.Queue()
        cls.subscriber = rospy.Subscriber("/rosout_agg", Log, cls.aggregated.put)
        cls.publisher = rospy.Publisher("/rosout", Log, queue_size=10)
        cls.wait_for(
            lambda: cls.subscriber.get_num_connections() and cls.publisher.get_num_connections()
        )

    @classmethod
    def wait_for(cls, condition):
        deadline_s = time.monotonic() + LIMIT_S
        while not condition():
            assert time.monotonic() < deadline_s, "rosout did not answer"
            time.sleep(POLL_S)

    def logged(self, level, text):
        """Publish an entry and return the lines that the file gains."""
        before = log_file().stat().st_size
        self.publisher.publish(entry(level, text))
        while self.aggregated.get(timeout=LIMIT_S).msg != text:
            pass
        lines = log_file().read_bytes()[before:].decode().splitlines()
        return [one for one in lines if one.startswith((" ", "12.5"))]

    def test_an_entry_gives_time_level_node_place_and_text(self):
        place = "/x_axis/axis_driver [axis.py:7(home)]"
        for level, name in ((2, "INFO"), (4, "WARN"), (16, "FATAL"), (3, "level 3")):
            self.assertEqual(
                self.logged(level, f"no endstop {level}\n"),
                [f"12.500000 {name} {place} no endstop {level}"],
            )

    def test_a_text_of_several_lines_cannot_be_taken_for_several_entries(self):
        lines = self.logged(2, "first\n9.0 FATAL /b [f:1(g)] forged")
        self.assertEqual(lines[1:], ["    9.0 FATAL /b [f:1(g)] forged"])


if __name__ == "__main__":
    rospy.init_node("rosout_test")
    rostest.rosrun("gpr20", "rosout_lines", RosoutTest)
