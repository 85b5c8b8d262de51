#!/usr/bin/env python3
"""Nodes that are alive but answer nothing are ended and restarted; the survey continues."""

import os
import shutil
import signal
import unittest
from urllib.parse import urlsplit

import psutil
import rosgraph
import rospy
import rostest
from survey_client import SurveyClient, node_pid, wait_until

from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import ControlStatus

TRACES = 18


def port_of(node):
    """Return the port on which a node answers; None while the master does not know it."""
    try:
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
    except rosgraph.MasterException:
        return None
    return urlsplit(uri).port


def is_watched(node):
    """Return whether a watchdog has asked the node: it keeps the connection."""
    ports = [
        connection.raddr.port
        for process in psutil.Process().parent().children()
        if any(word.endswith("gpr20_launch/watchdog") for word in process.cmdline())
        for connection in process.connections()
        if connection.status == psutil.CONN_ESTABLISHED
    ]
    return port_of(node) in ports


class HungNodesTest(unittest.TestCase):
    """The tests run in the order of their names; the robot keeps its state between them."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("hung_nodes_rostest")
        cls.client = SurveyClient()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def freeze(self, node):
        """Halt a node that is watched; return its process id."""
        wait_until(lambda: is_watched(node), f"nobody watches {node}")
        pid = node_pid(node)
        os.kill(pid, signal.SIGSTOP)
        return pid

    def wait_for_end_of(self, pid):
        """Wait until a process has been ended."""
        wait_until(lambda: not psutil.pid_exists(pid), f"process {pid} was not ended")

    def test_1_a_frozen_storage_and_window_are_restarted_and_the_survey_continues(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(4)
        window, port = self.freeze("/user_interface"), port_of("/user_interface")
        pid = self.freeze("/vna_processing")
        acknowledged = max(one.visited_points for one in self.client.progress)
        self.client.forget()
        self.wait_for_end_of(pid)
        traces = self.client.folder(survey_id) / "traces"
        self.assertGreaterEqual(len(list(traces.glob("*.json"))), acknowledged)
        self.client.check_complete(survey_id, TRACES)
        waiting = [one for one in self.client.statuses if one.code == ControlStatus.CHECKING]
        self.assertTrue(any("vna_processing" in message_from(one).all_details for one in waiting))
        self.assertTrue(any("continues by itself" in one.message for one in waiting))
        self.wait_for_end_of(window)
        wait_until(lambda: port_of("/user_interface") not in (None, port), "no other window")

    def test_2_a_frozen_control_is_restarted_and_its_survey_is_resumed(self):
        survey_id = self.client.begin()
        self.client.wait_for_visited(4)
        pid = self.freeze("/main_control")
        self.client.forget()
        self.wait_for_end_of(pid)
        self.client.wait_for_status(ControlStatus.IDLE)
        self.client.go_on(self.client.folder(survey_id).name)
        self.client.check_complete(survey_id, TRACES)


if __name__ == "__main__":
    rostest.rosrun("gpr20", "hung_nodes", HungNodesTest)
