#!/usr/bin/env python3
"""The recordings of a survey hold its end, and no replay of them looks like a robot."""

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import unittest
from pathlib import Path

import rosbag
import rosgraph
import rospkg
import rospy
import rostest
from mcap.reader import make_reader
from mcap_ros1.reader import read_ros1_messages
from survey_client import LIMIT_S, SurveyClient

from gpr20_msgs.msg import ControlStatus, Replay, SurveyCoverage

PACKAGES = rospkg.RosPack()
WINDOW = Path(PACKAGES.get_path("gpr20_user_interface")) / "test/ros/window_process.py"
FINISHED = "REPLAY ENDED"
BESIDE = "A recording plays on this robot's topics"
ENDING_LIMIT_S = 20.0
# Without the results of the axes, which would make the robot pause.
WINDOW_TOPICS = (
    *("/replay", "/control_status", "/control_survey_data", "/survey_coverage", "/trace"),
    *("/survey_metadata", "/survey_parameters", "/diagnostics", "/x_axis/current_coord"),
)
PLAYER = ("rosbag", "play", "-q")


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


@contextlib.contextmanager
def process(*command, **options):
    """Run a command; it is interrupted, as by Ctrl-C, in the end."""
    started = subprocess.Popen(command, **options)
    try:
        yield started
    finally:
        if started.poll() is None:
            started.send_signal(signal.SIGINT)
        try:
            started.wait(ENDING_LIMIT_S)
        except subprocess.TimeoutExpired:
            started.kill()
            started.wait()
        for stream in (started.stdin, started.stdout):
            if stream is not None and not stream.closed:
                stream.close()


@contextlib.contextmanager
def master():
    """Run a master of its own; return the environment of its nodes."""
    port = free_port()
    environment = {
        **os.environ,
        "ROS_MASTER_URI": f"http://localhost:{port}",
        "QT_QPA_PLATFORM": "offscreen",
    }
    command = ["rosmaster", "--core", "-p", str(port)]
    with process(*command, env=environment, stdout=subprocess.DEVNULL):
        wait_until(lambda: is_online(environment), "the master does not answer")
        yield environment


def is_online(environment):
    return rosgraph.is_master_online(environment["ROS_MASTER_URI"])


def wait_until(condition, what):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, what
        time.sleep(0.05)


def messages(folder, topic):
    """Return the messages of a topic in both recordings."""
    with rosbag.Bag(str(folder / "survey.bag")) as bag:
        in_bag = [one.message for one in bag.read_messages(topics=[topic])]
    path = folder / "survey.mcap"
    in_mcap = [one.ros_msg for one in read_ros1_messages(str(path), topics=[topic])]
    return in_bag, in_mcap


def without_mark(folder, target):
    """Write the bag as an earlier version did: without mark and end."""
    with rosbag.Bag(str(folder / "survey.bag")) as bag, rosbag.Bag(str(target), "w") as old:
        for topic, message, when, header in bag.read_messages(return_connection_header=True):
            ended = topic == "/control_status" and message.code == ControlStatus.FINISHED
            if topic != "/replay" and not ended:
                old.write(topic, message, when, connection_header=header)
    return target


def in_namespace(folder, target):
    """Write the bag as a robot with a namespace does; /diagnostics belongs to all robots."""
    with rosbag.Bag(str(folder / "survey.bag")) as bag, rosbag.Bag(str(target), "w") as own:
        for topic, message, when, header in bag.read_messages(return_connection_header=True):
            name = topic
            if topic == "/diagnostics":
                for status in message.status:
                    status.name = f"robot1/{status.name.lstrip('/')}"
            else:
                name = f"/robot1{topic}"
            own.write(name, message, when, connection_header=dict(header, topic=name))
    return target


class Window:
    """A window in a process of its own, which reports what it shows.

    Args:
        environment: Names its master.
        namespace: Of a replay; empty: it shows a robot.
    """

    def __init__(self, environment, namespace=""):
        self._environment = dict(environment, QT_QPA_PLATFORM="offscreen")
        self._options = ["--replay", f"__ns:={namespace}"] if namespace else []

    @contextlib.contextmanager
    def open(self):
        with process(
            sys.executable,
            str(WINDOW),
            *self._options,
            env=self._environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as self._process:
            self.shown()
            yield self
            # Without a question more to answer it ends.
            self._process.stdin.close()
            self._process.wait(LIMIT_S)

    def shown(self):
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def wait_for(self, condition, what):
        """Wait for what a window of a replay shows; nothing on the way may look like a robot."""
        seen = []

        def holds():
            seen.append(self.shown())
            assert seen[-1]["replay"] and not seen[-1]["stop"], seen[-1]
            return condition(seen[-1])

        try:
            wait_until(holds, what)
        except AssertionError as error:
            raise AssertionError(f"{what}: {seen[-1]}") from error
        return seen[-1]


class ReplayTest(unittest.TestCase):
    """The tests run in the order of their names and replay the survey of the first."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("replay_recorded_rostest")
        cls.client = SurveyClient()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.client.data)

    def check_end(self, status, outcome, complete):
        folder = self.client.folder(status.survey_id)
        self.assertEqual(json.loads((folder / "survey.json").read_text())["outcome"], outcome)
        for found in messages(folder, "/control_status"):
            self.assertEqual(
                (found[-1].code, found[-1].message, found[-1].message_json, found[-1].simulated),
                (status.code, status.message, status.message_json, True),
            )
        for found in messages(folder, "/control_survey_data"):
            self.assertEqual(found[-1].completion_percent == 100.0, complete)
        for found in messages(folder, "/survey_coverage"):
            self.assertEqual(found[-1].run_states == bytes([SurveyCoverage.MEASURED]), complete)
        for (mark,) in messages(folder, "/replay"):
            self.assertEqual((mark.survey_id, mark.folder), (status.survey_id, folder.name))
            self.assertEqual(mark.state, Replay.PLAYING)
        with (folder / "survey.mcap").open("rb") as stream:
            topics = [channel.topic for _, channel, _ in make_reader(stream).iter_messages()]
        self.assertEqual(topics[0], "/replay")
        with rosbag.Bag(str(folder / "survey.bag")) as bag:
            found = list(bag.read_messages(topics=["/replay"], return_connection_header=True))
        self.assertEqual([one.connection_header["latching"] for one in found], [b"1"])
        return folder

    def test_1_recordings_end_with_finished(self):
        survey_id, status = self.client.run_to_end()
        self.assertEqual(status.code, ControlStatus.FINISHED, status.message)
        type(self).folder = self.check_end(status, "finished", complete=True)
        self.assertEqual(status.survey_id, survey_id)

    def test_2_recordings_end_with_stopped_and_a_resumed_one_with_finished(self):
        self.client.begin(x_points=12)
        self.client.wait_for_visited(5)
        self.assertTrue(self.client.stop().success)
        status = self.client.wait_for_status(ControlStatus.STOPPED)
        folder = self.client.folder(status.survey_id)
        self.check_end(status, "stopped", complete=False)
        self.client.forget()
        self.assertTrue(self.client.resume(survey=folder.name).success)
        status = self.client.wait_for_status(ControlStatus.FINISHED)
        for found in messages(folder, "/control_status"):
            codes = [one.code for one in found]
            self.assertIn(ControlStatus.STOPPED, codes)
            self.assertEqual((found[-1].code, found[-1].message), (status.code, status.message))

    def test_3_a_window_of_a_replay_shows_the_survey_and_its_end_with_any_player(self):
        bag = str(self.folder / "survey.bag")
        old = without_mark(self.folder, self.client.data / "old.bag")
        other = in_namespace(self.folder, self.client.data / "robot1.bag")
        # Unlike replay.launch, these do not wait until the window has connected.
        player, node = [*PLAYER, "-d", "2", "--prefix=/replay"], ["rosrun", "gpr20_analysis"]
        named = f"Survey of {self.folder.name[:4]}-"
        ways = (
            ("replay", [*player, bag], named, "FINISHED"),
            ("replay", [*player, str(old)], "Recorded survey", "does not contain"),
            ("replay/robot1", [*player, str(other)], named, "FINISHED"),
            ("replay", [*node, "replay", "--start", "1", str(self.folder)], named, "FINISHED"),
        )
        for namespace, command, beginning, end in ways:
            with master() as environment:
                with Window(environment, namespace).open() as window:
                    self.assertIn("Waiting for a recording", window.shown()["survey"])
                    with process(*command, env=environment, stdout=subprocess.DEVNULL) as played:
                        window.wait_for(lambda one: one["on_radar"] == 18, "traces are missing")
                        # Of the nodes whose reports the recording has, which no robot says.
                        window.wait_for(lambda one: one["nodes"] > 5, "their health is missing")
                        played.wait(LIMIT_S)
                    after = window.wait_for(
                        lambda one: one["replay"].startswith(FINISHED), "the replay does not end"
                    )
                self.assertIn(beginning, after["survey"])
                self.assertIn(end, after["survey"])
                self.assertEqual((after["alarm"], after["locked"]), ("", True))
                self.assertEqual(
                    (after["on_map"], after["visited"]), (18, 18), f"{command}: {after}"
                )

    def test_4_a_player_on_the_topics_of_this_robot_is_not_shown_and_said_in_the_band(self):
        mark = rospy.Publisher("/replay", Replay, latch=True, queue_size=1)
        self.addCleanup(mark.unregister)
        mark.publish(Replay(survey_id="x", folder="x"))
        bag = str(self.folder / "survey.bag")
        self.client.begin(x_points=40, y_points=20)
        self.client.wait_for_visited(1)
        with Window(os.environ).open() as window:
            wait_until(lambda: window.shown()["title"] == "SURVEYING", "the window does not follow")
            visited, said = [], []
            with process(*PLAYER, bag, "--topics", *WINDOW_TOPICS) as player:
                deadline_s = time.monotonic() + 4.0
                while time.monotonic() < deadline_s and player.poll() is None:
                    shown = window.shown()
                    self.assertEqual((shown["replay"], shown["stop"]), ("", True), shown)
                    self.assertEqual(shown["title"], "SURVEYING")
                    self.assertEqual(shown["area_traces"], 1600)
                    visited.append(shown["visited"])
                    said.append(shown["survey"])
            self.assertEqual(visited, sorted(visited))
            self.assertTrue(any(BESIDE in one for one in said), said)
            wait_until(lambda: BESIDE not in window.shown()["survey"], "the band is not relieved")
            self.assertTrue(self.client.stop().success)
            self.client.wait_for_status(ControlStatus.STOPPED)

    def test_5_a_replay_beside_a_robot_disturbs_neither(self):
        self.client.begin(x_points=40, y_points=20)
        self.client.wait_for_visited(1)
        command = ["roslaunch", "gpr20", "replay.launch", f"survey:={self.folder}", "rate:=5"]
        with Window(os.environ).open() as window, Window(os.environ, "replay").open() as replay:
            wait_until(lambda: window.shown()["title"] == "SURVEYING", "the window does not follow")
            with process(*command, stdout=subprocess.DEVNULL) as played:
                while played.poll() is None:
                    shown, replayed = window.shown(), replay.shown()
                    self.assertEqual((shown["replay"], shown["stop"]), ("", True), shown)
                    self.assertEqual((shown["title"], shown["area_traces"]), ("SURVEYING", 1600))
                    self.assertNotIn(BESIDE, shown["survey"])
                    self.assertTrue(replayed["replay"] and not replayed["stop"], replayed)
            replay.wait_for(lambda one: one["on_radar"] == 18, "traces are missing")
        self.assertTrue(self.client.stop().success)
        self.client.wait_for_status(ControlStatus.STOPPED)

    def test_6_the_client_follows_a_replay_and_starts_nothing(self):
        client = ["rosrun", "gpr20_user_interface", "run_survey", "--bar", "never"]
        launch = ["gpr20", "replay.launch", f"survey:={self.folder.name}", "paused:=true"]
        with master() as environment:
            port = environment["ROS_MASTER_URI"].rsplit(":", 1)[1]
            with process(
                *["roslaunch", "-p", port, *launch],
                env=environment,
                cwd=self.folder.parent,
                stdout=subprocess.DEVNULL,
            ), process(
                *[*client, "--attach", "__ns:=replay"],
                env=environment,
                stdout=subprocess.PIPE,
                text=True,
            ) as attached:
                for options in ([], ["--resume"]):
                    refused = self.call(
                        environment, *client, *options, "--wait", "4", "__ns:=replay"
                    )
                    self.assertEqual(refused.returncode, 1, refused.stdout)
                    self.assertIn("A replay of a recorded survey is running", refused.stdout)
                faster = self.call(environment, "rosservice", "call", "/replay/set_rate", "10.0")
                self.assertIn("success: True", faster.stdout)
                self.call(environment, "rosservice", "call", "/replay/continue")
                output, _ = attached.communicate(timeout=LIMIT_S)
        self.assertEqual(attached.returncode, 5, output)
        self.assertIn("REPLAY: SURVEYING", output)
        self.assertIn("The recorded survey ended FINISHED", output)

    def call(self, environment, *command):
        """Run a command to its end; return its output."""
        return subprocess.run(
            command,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LIMIT_S,
        )

    def test_7_the_launch_opens_a_window_and_ends_with_it(self):
        self.check_launch(f"survey:={self.folder}", "ui:=true", "rate:=10")
        # The window alone, for rosbag play.
        self.check_launch()

    def check_launch(self, *options):
        with master() as environment:
            port = environment["ROS_MASTER_URI"].rsplit(":", 1)[1]
            with process(
                *["roslaunch", "-p", port, "gpr20", "replay.launch", *options],
                env=environment,
                stdout=subprocess.DEVNULL,
            ) as launched:
                nodes = rosgraph.Master("/test", environment["ROS_MASTER_URI"])
                if options:
                    self.wait_for_its_end(environment)
                wait_until(lambda: self.window_of(nodes), "there is no window")
                self.assertIsNone(launched.poll())
                self.call(environment, "rosnode", "kill", *self.window_of(nodes))
                launched.wait(LIMIT_S)

    def wait_for_its_end(self, environment):
        """Return when a replay says that it has ended; it stays then."""
        echo = ["rostopic", "echo", "-p", "/replay/replay/state"]
        with process(*echo, env=environment, stdout=subprocess.PIPE, text=True) as echoed:
            for line in echoed.stdout:
                if line.strip().rsplit(",", 1)[-1] == str(Replay.ENDED):
                    return

    def window_of(self, nodes):
        published, _subscribed, _services = nodes.getSystemState()
        names = {name for _topic, names in published for name in names}
        return [name for name in names if name.startswith("/replay/user_interface")]


if __name__ == "__main__":
    rostest.rosrun("gpr20", "replay_recorded", ReplayTest)
