#!/usr/bin/env python3
"""The real window, touched on a screen of its own, with the whole simulated robot.

`GPR20_REAL_TOUCHES` sets how many touches come at random, `GPR20_SEED` which.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List

import actionlib
import rosgraph
import rospkg
import rospy
import rostest

from gpr20_common.mid.codec import plain
from gpr20_msgs.msg import AxisAction, AxisGoal, ControlStatus
from gpr20_survey.axes import AxisId
from gpr20_user_interface.low.settings_file import RememberedPlan, SettingsFile

sys.path.append(str(Path(__file__).resolve().parents[5] / "tools/kits"))
sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gpr20"), "test", "ros"))
from survey_client import SurveyClient, node_pid
from wait_kit import wait_until
from window_kit import virtual_screen

TOUCHES = int(os.environ.get("GPR20_REAL_TOUCHES", "20"))
WIDTH_PX, HEIGHT_PX = 800, 480
# Shorter than a hold; the longest ones still open what a long press would.
LONGEST_TAP_S = 0.3
PLACE = re.compile(r"X (-?\d+)\D+(\d+)\D+Y (-?\d+)\D+(\d+)")
# Longer than its test, on a busy machine too.
LONG = {"start_mm": "50", "stop_mm": "430", "spacing_mm": "20", "points": "20"}
# 6 x 6 stops of two polarizations.
SHORT = {"x_stop_mm": 110.0, "x_points": 6, "y_stop_mm": 110.0, "y_points": 6}
LOG = ("log.jsonl", "log.copy.jsonl")
# What touches without a hold may add to the log: a permittivity, markers, a report on a stick.
ADDITIONS = {"decision", "marker", "marker_removed", "export", "audit", "bag"}
# Copies of what the log and the recording say.
COPIES = {"survey.json", "manifest.json", "survey.bag"}
MOVING = {
    ControlStatus.CHECKING,
    ControlStatus.HOMING,
    ControlStatus.SURVEYING,
    ControlStatus.PAUSING,
}


# As long as the window takes no touch after something has opened or closed, and a little more.
QUIET_S = 0.5
# How long a finger touches.
TAP_S = 0.06
HOLD_S = 1.3
LIMIT_S = 200.0


class TouchedWindow:
    """A window, and the finger on it.

    Args:
        arguments: Options of the window's program.
        environment: Variables of the window alone.
    """

    def __init__(self, *arguments: str, **environment: str) -> None:
        program = Path(__file__).with_name("window_process.py")
        self.process = subprocess.Popen(
            [sys.executable, str(program), *arguments],
            env={**os.environ, **environment},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            universal_newlines=True,
        )
        wait_until(lambda: self.takes_touches("top_bar.stop"), "the window is there")

    def find(self, name: str = "") -> Dict[str, Any]:
        """Return where a part of the window is on the screen, and how it is; empty: all of it."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(f"{name}\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError(f"the window has ended with {self.process.wait()}")
        return json.loads(line)

    def wait_for(self, condition: Callable[[Dict[str, Any]], bool], what: str) -> Dict[str, Any]:
        """Wait for what the window shows; return it."""
        seen: Dict[str, Any] = {}

        def holds() -> bool:
            seen.update(self.find())
            return condition(seen)

        try:
            wait_until(holds, what)
        except AssertionError as error:
            raise AssertionError(f"{error}: {seen}") from error
        return seen

    def takes_touches(self, name: str) -> bool:
        """Return whether a part of the window is seen and can be touched."""
        found = self.find(name)
        return bool(found["visible"] and found["enabled"])

    def tap(self, name: str, for_s: float = TAP_S) -> None:
        """Touch a part of the window when it takes touches."""
        wait_until(lambda: self.takes_touches(name), f"{name} takes touches")
        time.sleep(QUIET_S)
        found = self.find(name)
        middle = found["x"] + found["width"] // 2, found["y"] + found["height"] // 2
        self.tap_at(*middle, for_s)

    def tap_for(self, wanted: str, name: str) -> None:
        """Touch a part until it has opened another one: a touch is dropped where one closes."""

        def is_open() -> bool:
            if self.find(wanted)["visible"]:
                return True
            if self.takes_touches(name):
                self.tap(name)
            return False

        wait_until(is_open, f"{name} opens {wanted}")

    def hold(self, name: str) -> None:
        """Touch a part of the window for long: again if a busy one has noticed a break."""

        def has_acted() -> bool:
            self.tap(name, HOLD_S)
            with contextlib.suppress(AssertionError):
                wait_until(lambda: not self.takes_touches(name), limit_s=5.0)
                return True
            return False

        wait_until(has_acted, f"{name} acts")

    def tap_at(self, x: int, y: int, for_s: float = TAP_S) -> None:
        """Touch a place on the screen, whatever is there."""
        words = f"xdotool mousemove {x} {y} mousedown 1 sleep {for_s:g} mouseup 1"
        subprocess.run(words.split(), check=True, timeout=LIMIT_S)

    @contextlib.contextmanager
    def stalled(self) -> Iterator[None]:
        """Let the window do nothing for a time; touches meanwhile wait for it."""
        self.process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            self.process.send_signal(signal.SIGCONT)

    def end(self, end: Callable[[], None]) -> int:
        """Let something end the window; return how it ended."""
        if self.process.poll() is None:
            end()
        # Both streams are closed; waits for the end.
        self.process.communicate(timeout=LIMIT_S)
        return self.process.returncode

    def kill(self) -> int:
        """End it as a crash does; more than once does nothing."""
        return self.end(self.process.kill)


class Link:
    """The cable between the window and its master, which a test may pull out.

    Attributes:
        uri: Where the window finds its master.
    """

    def __init__(self, port: int) -> None:
        self._port = port
        self._ends: List[socket.socket] = []
        self._server = socket.create_server(("127.0.0.1", 0))
        self.uri = f"http://127.0.0.1:{self._server.getsockname()[1]}"
        threading.Thread(target=self._carry, daemon=True).start()

    def cut(self) -> None:
        self._port = 0
        for one in self._ends:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def _carry(self) -> None:
        while True:
            near, _address = self._server.accept()
            try:
                far = socket.create_connection(("127.0.0.1", self._port))
            except OSError:
                near.close()
                continue
            self._ends += near, far
            for ends in ((near, far), (far, near)):
                threading.Thread(target=copy, args=ends, daemon=True).start()


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
    """The tests run in the order of their names, with one robot, one screen and two windows."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.draw = random.Random(os.environ.get("GPR20_SEED", "1"))
        cls.client = SurveyClient()
        cls.data = cls.client.data
        cls.moves: List[Any] = []
        cls.subscribers = [
            rospy.Subscriber(f"{axis.value}_axis/axis/goal", rospy.AnyMsg, cls.moves.append)
            for axis in AxisId
        ]
        cls.link = Link(int(rosgraph.get_master_uri().rstrip("/").rsplit(":", 1)[1]))
        cls.screen = contextlib.ExitStack()
        cls.screen.enter_context(virtual_screen())
        cls.folder = Path(tempfile.mkdtemp())
        texts = {f"{axis}_{name}": text for axis in "xy" for name, text in LONG.items()}
        plan = RememberedPlan({**texts, "frequency_points": "101"})
        SettingsFile(cls.folder / "plan.yaml").write(plain(plan))
        cls.window = cls.opened("_full_screen:=true", f"_settings:={cls.folder}/window.yaml")

    @classmethod
    def tearDownClass(cls) -> None:
        cls.window.kill()
        cls.screen.close()
        shutil.rmtree(cls.folder)
        shutil.rmtree(cls.data)

    @classmethod
    def opened(cls, *arguments: str) -> TouchedWindow:
        return TouchedWindow(*arguments, ROS_MASTER_URI=cls.link.uri)

    def wait_for(self, condition: Callable[[Dict[str, Any]], bool], what: str) -> Dict[str, Any]:
        return self.window.wait_for(condition, what)

    def wait_for_title(self, title: str) -> Dict[str, Any]:
        return self.wait_for(lambda one: one["title"] == title, f"the robot is {title}")

    def wait_for_traces(self, more_than: int) -> Dict[str, Any]:
        return self.wait_for(lambda one: one["visited"] > more_than, "the survey takes traces")

    def hold_for(self, key: str) -> None:
        """Touch a key, and hold the button of the sheet that asks."""
        self.window.tap_for("start_sheet.hold", key)
        self.window.hold("start_sheet.hold")

    def test_1_a_survey_outlives_a_lost_vna_and_a_control_that_dies_until_a_finger_stops_it(
        self,
    ) -> None:
        window, client = self.window, self.client
        place = window.find("window")
        self.assertEqual(place["window"], place["screen"])
        self.hold_for("control.start")
        begun = self.wait_for_title("SURVEYING")
        self.wait_for_traces(2)

        self.addCleanup(lambda: client.set_fault(device="vna", fault="NONE"))
        client.set_fault(device="vna", fault="DROP")
        self.wait_for(lambda one: one["trouble"], "the loss is reported")
        held = self.wait_for_title("PAUSED")
        wait_until(lambda: window.takes_touches("notice.resume"), "a card says what to do")
        self.assertTrue(window.find("notice.first")["text"])
        client.set_fault(device="vna", fault="NONE")
        # The alarm ends with its cause, though the survey is still paused.
        shown = self.wait_for(lambda one: not one["trouble"], "the return is reported")
        self.assertEqual(shown["title"], "PAUSED")
        self.hold_for("notice.resume")
        held = self.wait_for_traces(held["visited"])

        os.kill(node_pid("/main_control"), signal.SIGKILL)
        self.wait_for(lambda one: one["condition"] == "survey.can_resume", "the loss is said")
        self.open_surveys()
        wait_until(self.is_chosen, "the first survey is chosen")
        self.hold_for("past.resume")
        window.tap("tab:SURVEY")
        shown = self.wait_for_title("SURVEYING")
        self.assertEqual(shown["survey_id"], begun["survey_id"])
        self.wait_for_traces(held["visited"])
        window.tap("top_bar.stop")
        shown = self.wait_for_title("STOPPED")
        self.assertIn("survey.can_resume", shown["codes"])
        self.wait_for(lambda one: not one["pending"], "STOP is answered")

    def open_surveys(self) -> None:
        """Close what hides the rail, and touch its key."""

        def is_open() -> bool:
            for key in ("past.list", "notice.close_button", "tab:SURVEYS"):
                if self.window.takes_touches(key):
                    if key == "past.list":
                        return True
                    self.window.tap(key)
            return False

        wait_until(is_open, "SURVEYS is open")

    def is_chosen(self) -> bool:
        """Touch the first row of the list; return whether its survey can be resumed."""
        if self.window.takes_touches("past.resume"):
            return True
        listed = self.window.find("past.list")
        self.window.tap_at(listed["x"] + listed["width"] // 2, listed["y"] + 30)
        return False

    def test_2_random_touches_and_a_stall_move_nothing_and_change_no_record(self) -> None:
        records = self.records()
        self.assertTrue(records)
        self.assertTrue(self.moves, "moves are noticed")
        self.moves.clear()
        self.client.forget()
        for number in range(TOUCHES):
            if number == TOUCHES // 2:
                with self.window.stalled():
                    for _ in range(5):
                        self.touch_anywhere()
            self.touch_anywhere()
            self.assertEqual(self.moves, [], f"touch {number}")
        self.assertTrue(self.window.takes_touches("top_bar.stop"))
        self.assertEqual(MOVING.intersection(one.code for one in self.client.statuses), set())
        self.assert_kept(records)

    def touch_anywhere(self) -> None:
        place = self.draw.randrange(WIDTH_PX), self.draw.randrange(HEIGHT_PX)
        self.window.tap_at(*place, self.draw.uniform(0.02, LONGEST_TAP_S))

    def records(self) -> Dict[Path, bytes]:
        files = [one for one in self.data.rglob("*") if one.is_file() and one.name not in COPIES]
        return {path: path.read_bytes() for path in files}

    def assert_kept(self, before: Dict[Path, bytes]) -> None:
        after = self.records()
        for path, content in before.items():
            self.assertIn(path, after)
            if path.name not in LOG:
                self.assertEqual(after[path], content, path)
                continue
            self.assertTrue(after[path].startswith(content), path)
            added = [json.loads(line) for line in after[path][len(content) :].splitlines()]
            self.assertLessEqual({one["kind"] for one in added}, ADDITIONS)

    def test_3_a_survey_goes_on_without_its_window_and_the_next_one_shows_it_whole(self) -> None:
        client = self.client

        def is_begun() -> bool:
            # Refused while the VNA is tested, which a random touch may ask for.
            with contextlib.suppress(AssertionError):
                client.begin(**SHORT)
                return True
            return False

        wait_until(is_begun, "a survey begins")
        client.wait_for_visited(4)
        self.assertEqual(self.window.kill(), -signal.SIGKILL)
        client.wait_for_visited(8)
        client.pause()
        client.wait_for_status(ControlStatus.PAUSED)

        # It keeps nothing.
        type(self).window = window = self.opened()
        self.wait_for(lambda one: "x_points: 6\n" in one["parameters"], "it has the plan")
        paused = self.wait_for(is_all_seen, "what it has missed is on MAP and RADAR")
        self.assertEqual((paused["title"], paused["area_traces"]), ("PAUSED", 72))
        self.assertTrue(8 <= paused["visited"] < 72 and paused["locked"] and paused["simulated"])
        self.hold_for("top_bar.pause")
        self.wait_for_title("FINISHED")
        done = self.wait_for(is_all_seen, "every trace is on MAP and RADAR")
        self.assertEqual(done["visited"], 72)
        first = "result.rows.0.title"
        wait_until(lambda: window.find(first)["visible"], "the places are shown")
        self.assertRegex(window.find(first)["text"], PLACE)

    def test_4_stop_reaches_an_axis_that_another_moves_without_a_main_control_and_a_master(
        self,
    ) -> None:
        client = actionlib.SimpleActionClient("y_axis/axis", AxisAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(LIMIT_S)))
        mover = threading.Thread(target=move_until_stopped, args=(client,))
        with frozen_control():
            mover.start()
            self.wait_for(lambda one: one["condition"] == "window.robot_moves", "it is said")
            self.link.cut()

            def is_stopped() -> bool:
                # One that comes between two moves stops none.
                self.window.tap("top_bar.stop")
                mover.join(1.0)
                return not mover.is_alive()

            wait_until(is_stopped, "the axis is stopped")
            self.wait_for(lambda one: not one["moving"], "every axis rests")
            wait_until(lambda: self.window.find("notice")["visible"], "the answers are shown")
        self.window.tap("notice.close_button")
        self.wait_for(lambda one: one["condition"] == "robot.master_lost", "the loss is said")

    def test_5_a_display_that_is_lost_never_crashes_it(self) -> None:
        self.assertEqual(self.window.end(self.screen.close), 4)


def is_all_seen(shown: Dict[str, Any]) -> bool:
    """Return whether every visited trace is on the map and in the radar pictures."""
    return shown["visited"] == shown["on_map"] == shown["on_radar"] > 0


def move_until_stopped(client: actionlib.SimpleActionClient) -> None:
    """Move an axis, as a person at a terminal does, until a move does not succeed."""
    for number in range(1000):
        client.send_goal(AxisGoal(target_coordinate=(700.0, 10.0)[number % 2]))
        client.wait_for_result(rospy.Duration(LIMIT_S))
        if client.get_state() != actionlib.GoalStatus.SUCCEEDED:
            break


@contextlib.contextmanager
def frozen_control() -> Iterator[None]:
    pid = node_pid("/main_control")
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


if __name__ == "__main__":
    rospy.init_node("test_window", disable_signals=True)
    rostest.rosrun("gpr20_user_interface", "window", Window)
