#!/usr/bin/env python3
"""The real window, touched on a screen of its own, with the whole simulated robot.

`GPR20_REAL_TOUCHES` sets how many touches come at random, `GPR20_SEED` which.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import random
import re
import shutil
import signal
import socket
import socketserver
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any, Callable, Dict, List, Tuple

import actionlib
import rosgraph
import rospkg
import rospy
import rostest
from touched_window import Screen, TouchedWindow
from waiting import LIMIT_S, wait_until

from gpr20_common.high.service_client import ServiceClient
from gpr20_msgs.msg import AxisAction, AxisGoal, ControlStatus
from gpr20_msgs.srv import Command
from gpr20_operator.files.settings_file import SettingsFile
from gpr20_operator.plan.memory import RememberedPlan, values_of
from gpr20_simulator.srv import SetFault
from gpr20_survey.axes.axis_id import AxisId

sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import node_pid

TOUCHES = int(os.environ.get("GPR20_REAL_TOUCHES", "30"))
WIDTH_PX, HEIGHT_PX = 800, 480
# Shorter than a hold; the longest ones still open what a long press would.
LONGEST_TAP_S = 0.3
PLACE = re.compile(r"X (-?\d+)\D+(\d+)\D+Y (-?\d+)\D+(\d+)")
GRID = {"start_mm": "50", "stop_mm": "150", "spacing_mm": "20", "points": "6"}
LOG = "log.jsonl"
# What touches without a hold may add to the log: a permittivity, markers, a report on a stick.
ADDITIONS = {"decision", "marker", "marker_removed", "export", "audit"}
# Copies of what the log says.
COPIES = {"survey.json", "manifest.json"}
MOVING = {
    ControlStatus.CHECKING,
    ControlStatus.HOMING,
    ControlStatus.SURVEYING,
    ControlStatus.PAUSING,
}


class Link:
    """The cable between the window and the master's computer, which a test may pull out.

    Attributes:
        uri: Where the window finds its master.
    """

    def __init__(self, port: int) -> None:
        self._ends: List[socket.socket] = []
        self._server = self._listening(0, port)
        self._port = self._server.server_address[1]
        self.uri = f"http://127.0.0.1:{self._port}"

    def cut(self) -> None:
        """Let nothing pass any more; more than once does nothing."""
        self._server.shutdown()
        self._server.server_close()
        for one in self._ends:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def join(self, port: int) -> None:
        """Let the window reach the master at a port, which may be another one."""
        self._server = self._listening(self._port, port)

    def _listening(self, port: int, target: int) -> socketserver.ThreadingTCPServer:
        ends = self._ends

        class Carrier(socketserver.BaseRequestHandler):
            def handle(self) -> None:
                with socket.create_connection(("127.0.0.1", target)) as far:
                    ends.extend((self.request, far))
                    threading.Thread(target=copy, args=(far, self.request), daemon=True).start()
                    copy(self.request, far)

        class Server(socketserver.ThreadingTCPServer):
            allow_reuse_address = True
            daemon_threads = True

        server = Server(("127.0.0.1", port), Carrier)
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        return server


def copy(source: socket.socket, target: socket.socket) -> None:
    """Carry what one side says to the other one, until either ends."""
    with contextlib.suppress(OSError):
        while True:
            said = source.recv(65536)
            if not said:
                break
            target.sendall(said)
        target.shutdown(socket.SHUT_WR)


class Window(unittest.TestCase):
    """The tests run in the order of their names, with one robot, one screen and one window."""

    @classmethod
    def setUpClass(cls) -> None:
        # The master's port, before anything takes it away.
        cls.master_port = int(rosgraph.get_master_uri().rstrip("/").rsplit(":", 1)[1])
        cls.data = Path(rospy.get_param("~data"))
        cls.draw = random.Random(os.environ.get("GPR20_SEED", "1"))
        cls.moves: List[str] = []
        cls.codes: List[int] = []
        cls.subscribers = [
            rospy.Subscriber(
                "control_status", ControlStatus, lambda one: cls.codes.append(one.code)
            ),
            *(
                rospy.Subscriber(f"{axis.value}_axis/axis/goal", rospy.AnyMsg, cls.moves.append)
                for axis in AxisId
            ),
        ]
        cls.link = Link(cls.master_port)
        cls.screen = Screen()
        cls.folder = Path(tempfile.mkdtemp())
        # A short survey: 6 x 6 stops of two polarizations.
        texts = {f"{axis}_{name}": text for axis in "xy" for name, text in GRID.items()}
        plan = RememberedPlan({**texts, "frequency_points": "101"})
        SettingsFile(cls.folder / "plan.yaml").write(values_of(plan))
        cls.window = cls.opened("_full_screen:=true")

    @classmethod
    def note(cls, status: ControlStatus) -> None:
        cls.codes.append(status.code)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.window.kill()
        cls.screen.kill()
        shutil.rmtree(cls.folder)
        shutil.rmtree(cls.data)

    @classmethod
    def opened(cls, *arguments: str) -> TouchedWindow:
        kept = (f"_settings:={cls.folder}/window.yaml", f"_profiles:={cls.folder}/profiles")
        return TouchedWindow(cls.screen, *kept, *arguments, ROS_MASTER_URI=cls.link.uri)

    def wait_for(self, condition: Callable[[Dict[str, Any]], bool], what: str) -> Dict[str, Any]:
        return self.window.wait_for(condition, what)

    def wait_for_title(self, title: str) -> Dict[str, Any]:
        return self.wait_for(lambda one: one["title"] == title, f"the robot is {title}")

    def wait_for_traces(self, more_than: int) -> Dict[str, Any]:
        return self.wait_for(lambda one: one["visited"] > more_than, "the survey takes traces")

    def start(self) -> None:
        """Start a survey with the plan that the window proposes."""
        window = self.window
        wait_until(lambda: self.may_start(window), "START is unlocked")
        window.tap_for("start_sheet.hold", "control.start")
        window.hold("start_sheet.hold")

    def may_start(self, window: TouchedWindow) -> bool:
        """Close what hides the plan; return whether START can be touched."""
        for key in ("notice.close_button", "result.plan"):
            if window.takes_touches(key):
                window.tap(key)
        return window.takes_touches("control.start")

    def resume(self, key: str) -> None:
        """Touch a key, and hold the button of the sheet that asks."""
        self.window.tap_for("start_sheet.hold", key)
        self.window.hold("start_sheet.hold")

    def stop(self) -> None:
        """Touch STOP, and wait until the survey has ended for that."""
        self.window.tap("top_bar.stop")
        shown = self.wait_for_title("STOPPED")
        self.assertIn("survey.stopped_on_request", shown["codes"])
        self.wait_for(lambda one: not one["pending"], "STOP is answered")

    def test_1_a_first_survey_is_seen_whole_though_its_window_was_killed(self) -> None:
        window = self.window
        place = window.find("window")
        self.assertEqual(place["frame"], place["screen"])
        self.assertEqual(place["window"], [0, 0, WIDTH_PX, HEIGHT_PX])
        self.assertEqual(place["outside"], [])
        wait_until(lambda: window.takes_touches("control.start"), "there is contact")
        self.start()
        self.wait_for_title("SURVEYING")
        before = self.wait_for_traces(4)
        self.assertEqual(window.kill(), -signal.SIGKILL)

        # The next one has a frame.
        type(self).window = window = self.opened("_full_screen:=false")
        wait_until(lambda: self.fits(window), "it is on the screen with its frame")
        now = self.wait_for_traces(before["visited"])
        self.assertEqual((now["title"], now["locked"], now["simulated"]), ("SURVEYING", True, True))
        window.tap("top_bar.pause")
        paused = self.wait_for_title("PAUSED")
        self.assertEqual(paused["parameters"], before["parameters"])
        # What it has missed is read back.
        paused = self.wait_for(is_all_seen, "every trace so far is on MAP and RADAR")
        self.assertLess(paused["visited"], paused["area_traces"])
        self.resume("top_bar.pause")
        done = self.wait_for_title("FINISHED")
        done = self.wait_for(is_all_seen, "every trace is on MAP and RADAR")
        self.assertEqual((done["visited"], done["area_traces"]), (72, 72))
        first = "result.rows.0.place"
        wait_until(lambda: window.find(first)["visible"], "the places are shown")
        self.assertRegex(window.find(first)["text"], PLACE)

    def fits(self, window: TouchedWindow) -> bool:
        known = window.find("window")
        left, top, width, height = known["frame"]
        inside = min(left, top) >= 0 and left + width <= WIDTH_PX and top + height <= HEIGHT_PX
        return inside and known["frame"] != known["window"] and not known["outside"]

    def test_2_random_touches_and_a_stall_move_nothing_and_change_no_record(self) -> None:
        records = self.records()
        self.assertTrue(records)
        self.assertTrue(self.moves, "moves are noticed")
        self.moves.clear()
        self.codes.clear()
        screens = set()
        for number in range(TOUCHES):
            if number == TOUCHES // 2:
                with self.window.stalled():
                    for _ in range(5):
                        self.touch_anywhere()
            screens.add(self.touch())
            self.assertEqual(self.moves, [], f"touch {number}")
        self.assertTrue(self.window.takes_touches("top_bar.stop"))
        # They were no touches of a window that takes none.
        self.assertGreater(len(screens), 3)
        self.assertEqual(MOVING.intersection(self.codes), set())
        self.assert_kept(records)

    def touch(self) -> Tuple[Tuple[int, int], ...]:
        """Touch a key or anywhere, or wipe; return the places of the keys that were looked at."""
        chance = self.draw.random()
        keys = self.window.find("keys")["keys"] if chance < 0.5 else []
        if keys:
            x, y = self.draw.choice(keys)
            self.window.tap_at(x, y, self.draw.uniform(0.02, LONGEST_TAP_S))
        elif chance < 0.6:
            self.window.drag(self.place(), self.place())
        else:
            self.touch_anywhere()
        return tuple(map(tuple, keys))

    def touch_anywhere(self) -> None:
        self.window.tap_at(*self.place(), self.draw.uniform(0.02, 0.1))

    def place(self) -> Tuple[int, int]:
        return self.draw.randrange(WIDTH_PX), self.draw.randrange(HEIGHT_PX)

    def records(self) -> Dict[Path, bytes]:
        """Return what is on the disk of the survey: digests, and the log as it is."""
        found = {}
        for path in self.data.rglob("*"):
            if path.is_file() and path.name not in COPIES:
                content = path.read_bytes()
                found[path] = content if path.name == LOG else hashlib.sha256(content).digest()
        return found

    def assert_kept(self, before: Dict[Path, bytes]) -> None:
        after = self.records()
        for path, content in before.items():
            self.assertIn(path, after)
            if path.name != LOG:
                self.assertEqual(after[path], content, path)
                continue
            self.assertTrue(after[path].startswith(content), path)
            added = [json.loads(line) for line in after[path][len(content) :].splitlines()]
            self.assertLessEqual({one["kind"] for one in added}, ADDITIONS)

    def test_3_stop_reaches_an_axis_whoever_moves_it_though_the_main_control_is_frozen(
        self,
    ) -> None:
        # Whatever the random touches left open, with the settings that are kept.
        self.assertEqual(self.window.end(self.window.process.terminate), 0)
        type(self).window = self.opened("_full_screen:=true")
        self.wait_for(lambda one: one["title"] != "—", "there is contact")
        self.send(AxisId.Y, 790.0)
        with self.frozen_control():
            # Slow, and by nobody whom the main control knows of.
            homed: List[Any] = []
            homing = threading.Thread(target=self.home, args=(AxisId.Y, homed))
            homing.start()
            shown = self.wait_for(lambda one: one["moving"] == ["y"], "the axis moves")
            self.assertEqual(shown["condition"], "window.robot_moves")
            self.window.tap("top_bar.stop")
            self.wait_for(lambda one: not one["moving"], "every axis rests")
            homing.join(LIMIT_S)
            self.assertFalse(homed[0].success, "STOP came before the axis was homed")
            wait_until(lambda: self.window.find("notice")["visible"], "the answers are shown")
        self.window.tap("notice.close_button")
        self.wait_for(lambda one: not one["condition"], "the main control is back")

    def home(self, axis: AxisId, answers: List[Any]) -> None:
        answers.append(ServiceClient(f"{axis.value}_axis/homing", Command).call(LIMIT_S))

    def send(self, axis: AxisId, target_mm: float) -> None:
        """Move an axis as a person at a terminal does, to the end."""
        client = actionlib.SimpleActionClient(f"{axis.value}_axis/axis", AxisAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(LIMIT_S)))
        client.send_goal(AxisGoal(target_coordinate=target_mm))
        self.assertTrue(client.wait_for_result(rospy.Duration(LIMIT_S)))

    @contextlib.contextmanager
    def frozen_control(self) -> Any:
        pid = node_pid("/main_control")
        os.kill(pid, signal.SIGSTOP)
        try:
            yield
        finally:
            os.kill(pid, signal.SIGCONT)

    def test_4_a_vna_that_is_gone_is_said_and_the_survey_goes_on_when_it_is_back(self) -> None:
        set_fault = ServiceClient("simulator/set_fault", SetFault)
        self.addCleanup(lambda: set_fault.call(LIMIT_S, device="vna", fault="NONE", count=0))
        self.start()
        self.wait_for_title("SURVEYING")
        self.wait_for_traces(2)
        set_fault.call(LIMIT_S, device="vna", fault="DROP", count=0)
        self.wait_for(lambda one: one["trouble"], "the loss is reported")
        held = self.wait_for_title("PAUSED")
        wait_until(lambda: self.window.takes_touches("notice.resume"), "a card says what to do")
        self.assertTrue(self.window.find("notice.first")["text"])
        set_fault.call(LIMIT_S, device="vna", fault="NONE", count=0)
        # The alarm ends with its cause, though the survey is still paused.
        shown = self.wait_for(lambda one: not one["trouble"], "the return is reported")
        self.assertEqual(shown["title"], "PAUSED")
        self.resume("notice.resume")
        self.wait_for_traces(held["visited"])
        with self.frozen_control():
            self.window.tap("top_bar.stop")
            self.wait_for(lambda one: not one["moving"], "every axis rests")
        self.stop()

    def test_5_a_control_that_dies_interrupts_a_survey_that_a_finger_resumes_and_stops(
        self,
    ) -> None:
        self.start()
        begun = self.wait_for_title("SURVEYING")
        held = self.wait_for_traces(2)
        os.kill(node_pid("/main_control"), signal.SIGKILL)
        self.wait_for(lambda one: one["condition"] == "window.interrupted", "the loss is said")
        self.may_start(self.window)
        self.window.tap_for("past.list", "tab:SURVEYS")
        self.choose_first()
        self.resume("past.resume")
        self.window.tap("tab:SURVEY")
        shown = self.wait_for_title("SURVEYING")
        self.assertEqual(shown["survey_id"], begun["survey_id"])
        self.wait_for_traces(held["visited"])
        self.link.cut()
        self.wait_for(lambda one: one["condition"] == "window.master_lost", "the loss is said")
        # STOP needs no master.
        self.stop()

    def choose_first(self) -> None:
        """Touch the first row of the list, when it is there, until it is chosen."""

        def is_chosen() -> bool:
            if self.window.takes_touches("past.resume"):
                return True
            listed = self.window.find("past.list")
            self.window.tap_at(listed["x"] + listed["width"] // 2, listed["y"] + 30)
            return False

        wait_until(is_chosen, "it is chosen")

    def test_6_the_next_master_is_joined(self) -> None:
        self.link.cut()
        with tempfile.TemporaryDirectory() as log, free_port() as port:
            # Empty: it knows nothing of the nodes of the former one.
            command = ["rosmaster", "--core", "-p", str(port)]
            master = subprocess.Popen(command, env={**os.environ, "ROS_LOG_DIR": log})
            try:
                self.join(f"http://127.0.0.1:{port}", port)
            finally:
                master.kill()
                master.wait(LIMIT_S)

    def join(self, uri: str, port: int) -> None:
        graph = rosgraph.Master(rospy.get_name(), uri)
        wait_until(graph.is_online, "the next master is there")
        self.link.join(port)
        self.wait_for(lambda one: one["condition"] != "window.master_lost", "the return is said")

        def subscribed() -> List[str]:
            return [topic for topic, _nodes in graph.getSystemState()[1]]

        wait_until(lambda: "/control_status" in subscribed(), "the window has joined it")

    def test_7_a_display_that_is_lost_never_crashes_it(self) -> None:
        self.assertEqual(self.window.end(self.screen.kill), 4)


@contextlib.contextmanager
def free_port() -> Any:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    yield port


def is_all_seen(shown: Dict[str, Any]) -> bool:
    """Return whether every visited trace is on the map and in the radar pictures."""
    return shown["visited"] == shown["on_map"] == shown["on_radar"] > 0


if __name__ == "__main__":
    rospy.init_node("test_window", disable_signals=True)
    rostest.rosrun("gpr20_user_interface", "window", Window)
