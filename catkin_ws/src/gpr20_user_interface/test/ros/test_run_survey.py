#!/usr/bin/env python3
"""The terminal client against a real ROS graph and a fake main_control."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import threading
import unittest
from typing import List
from xmlrpc.server import SimpleXMLRPCServer

import rosnode
import rospkg
import rospy
import rostest
from fake_main_control import FakeMainControl
from waiting import LIMIT_S, wait_until

from gpr20_common.message import Message
from gpr20_msgs.msg import ControlStatus
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_state import SurveyState

SMALL = ["--x-points", "3", "--y-points", "3"]  # 18 traces


def has_terminals() -> bool:
    """Return whether this machine has pseudo-terminals; a chroot without /dev/pts has none."""
    try:
        ends = pty.openpty()
    except OSError:
        return False
    for end in ends:
        os.close(end)
    return True


def read_until(terminal: int, text: str) -> str:
    """Return what a program writes on its terminal until it contains a text, or to its end."""
    output = b""
    while not text or text.encode() not in output:
        if not select.select([terminal], [], [], LIMIT_S)[0]:
            raise AssertionError(output.decode())
        try:
            output += os.read(terminal, 4096)
        except OSError:  # the program has ended
            break
    return output.decode()


class RunSurvey(unittest.TestCase):
    def setUp(self) -> None:
        self.namespace = "/" + self._testMethodName
        self.fake = FakeMainControl(self.namespace)
        self.addCleanup(self.fake.close)
        self.processes: List[subprocess.Popen] = []

    def tearDown(self) -> None:
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.communicate()

    def client(self, *arguments: str, master: str = "", terminal: int = -1) -> subprocess.Popen:
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        if terminal >= 0:
            streams = dict.fromkeys(("stdin", "stdout", "stderr"), terminal)
        folder = rospkg.RosPack().get_path("gpr20_user_interface")
        process = subprocess.Popen(
            [
                sys.executable,
                os.path.join(folder, "nodes", "run_survey"),
                *arguments,
                f"__ns:={self.namespace}",
            ],
            **streams,
            universal_newlines=True,
            env={
                **os.environ,
                "LANGUAGE": "en",
                "ROS_MASTER_URI": master or os.environ["ROS_MASTER_URI"],
            },
        )
        self.processes.append(process)
        return process

    def end_of(self, process: subprocess.Popen) -> str:
        output, _ = process.communicate(timeout=LIMIT_S)
        return output

    def surveying_client(self, *arguments: str) -> subprocess.Popen:
        self.fake.point_limit = 5
        process = self.client(*SMALL, *arguments)
        wait_until(lambda: self.fake.visited == 5, "the survey takes points")
        return process

    def paused_client(self) -> subprocess.Popen:
        process = self.surveying_client()
        self.fake.pause("the VNA does not answer")
        return process

    def test_codes_are_those_of_the_message(self) -> None:
        for code in SurveyState:
            self.assertEqual(code, getattr(ControlStatus, code.name))

    def test_soil_operator_site_notes_and_position_go_with_the_start(self) -> None:
        note = ["--operator", "Lucía Peña", "--site", "El Carmen", "--notes", "wet\nsoil"]
        note += ["--position=-4.60283,-74.06514", "--permittivity", "4.5"]
        process = self.client(*SMALL, *note)
        output = self.end_of(process)
        self.assertEqual(process.returncode, 0, output)
        position = Wgs84Position(-4.60283, -74.06514)
        expected = Annotation("Lucía Peña", "El Carmen", "wet\nsoil", position)
        self.assertEqual(self.fake.annotation, expected)
        self.assertEqual(self.fake.permittivity, 4.5)

    def test_follows_a_survey_to_its_end(self) -> None:
        process = self.client(*SMALL)
        output = self.end_of(process)
        self.assertEqual(process.returncode, 0, output)
        self.assertEqual(self.fake.visited, 18)
        for part in ("18 traces", "100.0 %", "less than 1 min left", "SIMULATED", "/data/survey"):
            self.assertIn(part, output)
        self.assertIn(f"Survey id: {self.fake.survey_id}", output)

    def test_bar_shows_the_same(self) -> None:
        process = self.client(*SMALL, "--bar", "always")
        output = self.end_of(process)
        self.assertEqual(process.returncode, 0, output)
        for part in ("18/18", "100%", "left (measured)", "SIMULATED"):
            self.assertIn(part, output)

    def test_refusal_of_the_control_is_told(self) -> None:
        # 700 mm is within the documented 0..800 and beyond this robot's axis.
        process = self.client("--x-stop-mm", "700")
        output = self.end_of(process)
        self.assertEqual(process.returncode, 1, output)
        self.assertIn("x stop is 700 mm; it must lie between 0 and 650 mm", output)
        self.assertEqual(self.fake.starts, 0)

    def test_ctrl_c_stops_the_survey_and_waits_for_it(self) -> None:
        self.fake.may_stop.clear()
        process = self.surveying_client()
        process.send_signal(signal.SIGINT)
        wait_until(lambda: self.fake.code == ControlStatus.STOPPING, "stop was asked")
        self.assertIsNone(process.poll())
        self.fake.may_stop.set()
        output = self.end_of(process)
        self.assertEqual(process.returncode, 130, output)
        self.assertIn("Survey stopped.\nstopped by request", output)
        self.assertEqual(self.fake.code, ControlStatus.STOPPED)

    def test_sigterm_stops_the_survey_too(self) -> None:
        process = self.surveying_client()
        process.send_signal(signal.SIGTERM)
        output = self.end_of(process)
        self.assertEqual(process.returncode, 130, output)
        self.assertEqual(self.fake.code, ControlStatus.STOPPED)

    def test_second_ctrl_c_leaves_at_once_and_warns(self) -> None:
        self.fake.may_stop.clear()
        process = self.surveying_client()
        process.send_signal(signal.SIGINT)
        wait_until(lambda: self.fake.stops > 0, "stop was asked")
        process.send_signal(signal.SIGINT)
        output = self.end_of(process)
        self.assertEqual(process.returncode, 130, output)
        self.assertIn("the robot may still move", output)
        self.assertEqual(self.fake.code, ControlStatus.STOPPING)

    def test_paused_survey_is_left_paused_and_can_be_resumed(self) -> None:
        process = self.paused_client()
        output = self.end_of(process)
        self.assertEqual(process.returncode, 4, output)
        self.assertIn("the VNA does not answer", output)
        self.assertIn("--resume", output)
        self.assertEqual(self.fake.code, ControlStatus.PAUSED)
        self.fake.point_limit = 18
        resumed = self.client("--resume")
        output = self.end_of(resumed)
        self.assertEqual(resumed.returncode, 0, output)
        self.assertIn(self.fake.survey_id, output)

    def test_another_vna_is_used_only_if_it_is_accepted(self) -> None:
        self.end_of(self.paused_client())
        self.fake.other_analyzer = "Anritsu,MS2026C/2,62011033,1.23"
        refused = self.client("--resume")
        output = self.end_of(refused)
        self.assertEqual(refused.returncode, 1, output)
        self.assertIn("the VNA is Anritsu,MS2026C/2,62011033,1.23, but", output)
        self.assertIn("--accept-analyzer Anritsu,MS2026C/2,62011033,1.23", output)
        self.assertEqual(self.fake.code, ControlStatus.PAUSED)
        self.fake.point_limit = 18
        resumed = self.client("--resume", "--accept-analyzer", self.fake.other_analyzer)
        output = self.end_of(resumed)
        self.assertEqual(resumed.returncode, 0, output)
        self.assertEqual(self.fake.resumed_with, ["", self.fake.other_analyzer])

    @unittest.skipUnless(has_terminals(), "no terminals here")
    def test_another_vna_is_asked_for_on_a_terminal(self) -> None:
        self.end_of(self.paused_client())
        self.fake.other_analyzer = "Anritsu,MS2026C/2,62011033,1.23"
        self.fake.point_limit = 18
        for reply, code, left in (("n", 1, ControlStatus.PAUSED), ("y", 0, ControlStatus.FINISHED)):
            with self.subTest(reply):
                ours, theirs = pty.openpty()
                resumed = self.client("--resume", "--bar", "never", terminal=theirs)
                os.close(theirs)
                output = read_until(ours, "[y/N]")
                os.write(ours, f"{reply}\n".encode())
                output += read_until(ours, "")
                self.assertEqual(resumed.wait(LIMIT_S), code, output)
                os.close(ours)
                self.assertEqual(self.fake.code, left)

    def test_attached_client_follows_without_starting(self) -> None:
        first = self.surveying_client()
        second = self.client("--attach", "--on-pause", "wait")
        wait_until(lambda: self.fake.listeners() >= 2, "both listen")
        self.fake.point_limit = 18
        outputs = [self.end_of(first), self.end_of(second)]
        self.assertEqual((first.returncode, second.returncode), (0, 0), outputs)
        self.assertEqual(self.fake.starts, 1)

    def test_attaching_to_nothing_says_so(self) -> None:
        process = self.client("--attach")
        output = self.end_of(process)
        self.assertEqual(process.returncode, 1, output)
        self.assertIn("No survey is running. The main control is IDLE", output)

    def test_vanished_control_ends_the_client_with_a_failure(self) -> None:
        process = self.surveying_client()
        self.fake.close()
        output = self.end_of(process)
        self.assertEqual(process.returncode, 3, output)
        self.assertIn("No contact with the main control for", output)

    def test_failed_survey_is_a_failure(self) -> None:
        process = self.surveying_client()
        self.fake.fail("the disk is full")
        output = self.end_of(process)
        self.assertEqual(process.returncode, 3, output)
        self.assertIn("the disk is full", output)

    def test_absent_control_is_told_with_what_to_start(self) -> None:
        self.fake.close()
        process = self.client("--wait", "1")
        output = self.end_of(process)
        self.assertEqual(process.returncode, 1, output)
        self.assertIn("roslaunch gpr20 survey.launch", output)

    def test_absent_master_is_told_within_the_limit(self) -> None:
        # Nobody listens on the discard port.
        process = self.client("--wait", "1", master="http://127.0.0.1:9")
        output = self.end_of(process)
        self.assertEqual(process.returncode, 1, output)
        self.assertIn("http://127.0.0.1:9", output)

    def test_a_master_that_dies_while_it_is_joined_is_told_within_the_limit(self) -> None:
        # It says that it is there and is gone before anybody can register.
        master = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        master.register_function(lambda caller: (1, "", os.getpid()), "getPid")

        def answer_once() -> None:
            master.handle_request()
            master.server_close()

        thread = threading.Thread(target=answer_once)
        thread.start()
        process = self.client("--wait", "1", master=f"http://127.0.0.1:{master.server_address[1]}")
        output = self.end_of(process)
        thread.join()
        self.assertEqual(process.returncode, 1, output)
        self.assertIn("window.no_master", output)

    def test_ctrl_c_while_waiting_for_main_control_stops_nothing(self) -> None:
        self.fake.close()
        waiting = self.client("--wait", "60", "__name:=waiting")
        node = f"{self.namespace}/waiting"
        wait_until(lambda: node in rosnode.get_node_names(), "the client waits")
        waiting.send_signal(signal.SIGINT)
        output = self.end_of(waiting)
        self.assertEqual(waiting.returncode, 130, output)
        # It is on the graph a moment before it waits: said in either of two sentences.
        self.assertIn("nothing was started", output.lower())

    def test_lines_are_in_the_language_that_is_asked_for_with_the_details_behind_them(self) -> None:
        process = self.surveying_client("--language", "es")
        self.fake.pause(Message("the disk is full", details="errno 28"))
        output = self.end_of(process)
        self.assertEqual(process.returncode, 4, output)
        self.assertIn("Campaña EN PAUSA", output)
        self.assertIn("\nel disco está lleno (errno 28)\n", output)
        self.assertIn("trazas", output)
        self.assertIn("ROBOT SIMULADO", output)


if __name__ == "__main__":
    rospy.init_node("test_run_survey", disable_signals=True)
    rostest.rosrun("gpr20_user_interface", "run_survey", RunSurvey)
