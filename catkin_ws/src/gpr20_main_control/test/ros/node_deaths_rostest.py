#!/usr/bin/env python3
"""Nodes that die or hang: control_status names them, and the survey loses nothing."""

import contextlib
import os
import shutil
import signal
import sys
import unittest
from urllib.parse import urlsplit

import psutil
import rosgraph
import rospkg
import rospy
import rostest

from gpr20_common.high.answers import message_from
from gpr20_msgs.msg import ControlStatus

# The client of the whole graph's tests is the client of these, too.
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import SurveyClient, json_traces, node_pid, wait_until

TRACES = 18
# Each dies while the survey measures; the survey waits for it and continues by itself.
DEATHS = (
    ("x_axis/axis_driver",),
    ("z_axis/axis_driver", "height_sensor"),
    ("vna_acquisition", "simulator"),
    ("vna_processing",),
)


def missing_nodes(status):
    """Return the nodes that do not answer, by the warning of a status."""
    warning = message_from(status).values.get("warning")
    return () if warning is None else warning.all_details


def watched(node):
    """Return the process id of a node, when a watchdog has asked it: it keeps the connection."""

    def is_watched():
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
        ports = []
        for process in psutil.Process().parent().children():
            # Others end meanwhile.
            with contextlib.suppress(psutil.NoSuchProcess):
                if any(word.endswith("gpr20_launch/watchdog") for word in process.cmdline()):
                    ports += [one.raddr.port for one in process.net_connections() if one.raddr]
        return urlsplit(uri).port in ports

    wait_until(is_watched, f"nobody watches {node}")
    return node_pid(node)


def wait_for_end_of(pid):
    wait_until(lambda: not psutil.pid_exists(pid), f"process {pid} was not ended")


class NodeDeathsTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("node_deaths_rostest")
        cls.client = SurveyClient()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def tearDown(self):
        # A test that failed must not be in the way of the next one.
        if self.client.statuses and self.client.statuses[-1].code == ControlStatus.PAUSED:
            self.client.stop()
            self.client.wait_for_status(ControlStatus.STOPPED)

    def signal(self, number, *nodes):
        """Send a signal to nodes, and wait until statuses warn that these do not answer."""
        pids = [node_pid(f"/{node}") for node in nodes]
        self.client.forget()
        for pid in pids:
            os.kill(pid, number)
        statuses = self.client.statuses
        for node in nodes:
            self.client.wait(lambda: any(node in missing_nodes(one) for one in statuses))  # noqa: B023
        return pids

    def wait_until_all_answer(self):
        self.client.wait(lambda: not missing_nodes(self.client.statuses[-1]))

    def test_1_a_survey_waits_for_every_node_that_dies_and_continues_by_itself(self):
        survey_id = self.client.begin()
        visited = 3
        for nodes in DEATHS:
            self.client.wait_for_visited(visited)
            self.signal(signal.SIGKILL, *nodes)
            self.client.wait(
                lambda: any(one.code == ControlStatus.CHECKING for one in self.client.statuses)
            )
            self.wait_until_all_answer()
            visited += 3
        self.client.check_complete(survey_id, TRACES)

    def test_2_a_death_while_paused_is_said_and_the_survey_stays_paused(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(2)
        self.assertTrue(self.client.pause().success)
        self.client.wait_for_status(ControlStatus.PAUSED)
        self.signal(signal.SIGKILL, "vna_processing", "y_axis/axis_driver")
        self.wait_until_all_answer()
        self.assertEqual({one.code for one in self.client.statuses}, {ControlStatus.PAUSED})
        self.client.go_on(survey_id)
        self.client.check_complete(survey_id, TRACES)

    def test_3_hang_stop_and_death_of_the_control_lose_nothing(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(3)
        (pid,) = self.signal(signal.SIGSTOP, "vna_acquisition")
        with contextlib.suppress(ProcessLookupError):  # ended, if this computer is slow
            os.kill(pid, signal.SIGCONT)
        self.client.wait_for_visited(6)
        self.signal(signal.SIGKILL, "z_axis/axis_driver")
        # A survey that holds can be stopped.
        self.assertTrue(self.client.stop().success)
        status = self.client.wait_for_status(ControlStatus.STOPPED)
        folder = self.client.folder(survey_id)
        self.assertIn(f"{len(json_traces(folder))} of {TRACES} traces", status.message)
        self.wait_until_all_answer()
        pid = watched("/main_control")
        self.client.go_on(survey_id)
        self.client.wait_for_status(ControlStatus.SURVEYING)
        # The watchdog ends it.
        os.kill(pid, signal.SIGSTOP)
        self.client.forget()
        wait_for_end_of(pid)
        self.client.wait_for_status(ControlStatus.IDLE)
        # Another one is begun first, and the one that was cut off stays resumable.
        self.client.check_complete(self.client.begin(), TRACES)
        self.client.go_on(folder.name)
        self.client.check_complete(survey_id, TRACES)

    def test_4_a_frozen_storage_is_restarted_and_the_survey_continues(self):
        pid = watched("/vna_processing")
        survey_id = self.client.begin()
        self.client.wait_for_visited(4)
        os.kill(pid, signal.SIGSTOP)
        # Of the survey before, too, progress may have come late.
        own = [one for one in self.client.progress if one.survey_id == survey_id]
        acknowledged = max(one.visited_points for one in own)
        self.client.forget()
        wait_for_end_of(pid)
        self.assertGreaterEqual(len(json_traces(self.client.folder(survey_id))), acknowledged)
        self.client.check_complete(survey_id, TRACES)
        waiting = [one for one in self.client.statuses if one.code == ControlStatus.CHECKING]
        self.assertTrue(any("vna_processing" in message_from(one).all_details for one in waiting))


if __name__ == "__main__":
    rostest.rosrun("gpr20_main_control", "node_deaths", NodeDeathsTest)
