"""The page at a distance in a real browser: its accounts, and what a person does with it."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import time
from pathlib import Path
from typing import Iterator

import pytest
import rospy
from browser_kit import Browser
from robot_kit import LaunchedRobot, free_port

from gpr20_common.low.clock import Clock
from gpr20_operator.high.control_client import ControlClient, WebPageClient
from gpr20_operator.robot.events import Senders, StartPlan
from gpr20_operator.robot.remote_control import Arming
from gpr20_operator.robot.snapshot import SurveyModel
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.survey_parameters import SurveyParameters

PASSWORD = "correct horse battery staple"
TAKEN, TAKEN_LIMIT_S = "cannot listen", 60.0
# Whether a process is a node, and whether that has ended.
NODE_STATE = (
    (rospy.client, "_init_node_args"),
    *((rospy.core, name) for name in ("_client_ready", "_in_shutdown", "_shutdown_flag")),
)
PEOPLE = {"vera": "watch", "otto": "control", "ada": "control"}

PLAN = SurveyParameters(
    vna_address="127.0.0.1",
    start_frequency_hz=600e6,
    stop_frequency_hz=6e9,
    frequency_points=101,
    x_start_mm=100.0,
    x_stop_mm=300.0,
    x_points=21,
    y_start_mm=100.0,
    y_stop_mm=300.0,
    y_points=21,
)


class Touchscreen:
    """The window as far as the page needs it: it follows the robot, and allows remote control."""

    def __init__(self) -> None:
        self.model = SurveyModel(Clock())

        self.control = ControlClient(self._take, Senders("/"))
        self.web = WebPageClient(self._take, "/")
        self.arming = Arming(Clock(), self.web.send)
        for client in (self.control, self.web):
            client.listen()
        self.control.set_watched(True)

    def _take(self, event: object) -> None:
        self.model.handle(event)
        self.arming.take(event)

    def note(self) -> None:
        """Take what is known now, as the window does five times a second."""
        self.arming.note(self.model.state(), StartPlan(PLAN, EMPTY, "", 4.0))

    def close(self) -> None:
        """Leave the graph."""
        self.control.close()
        self.web.close()


def write_config(config: Path, web: Path, port: int) -> None:
    """Write the configuration of a robot with a page on a port, and its accounts."""
    create = ["rosrun", "gpr20_launch", "robot_config", "create", str(config)]
    subprocess.run(create, check=True, capture_output=True)
    (config / "web.yaml").write_text(f"port: {port}\nfolder: {web}\n")
    for name, role in PEOPLE.items():
        words = ["users", "add", name, "--role", role, "--stdin", "--folder", str(web)]
        subprocess.run(
            ["rosrun", "gpr20_web", *words], input=f"{PASSWORD}\n", text=True, check=True
        )


class Site:
    """The robot in its folder, its page at an address, a browser and the window."""

    def __init__(self, robot: LaunchedRobot, address: str, folder: Path) -> None:
        self.robot, self.address, self.folder = robot, address, folder
        self.browser = Browser()
        self.screen = Touchscreen()
        # As the window does it, or the page takes it for one that hangs.
        self.browser.meanwhile = self.screen.note

    def opens(self) -> bool:
        """Open the page, and return that it could be opened."""
        self.browser.open(f"{self.address}/")
        return True

    def log_in(self, name: str, language: str = "en") -> None:
        """Open the page in a language, as somebody else than before."""
        browser = self.browser
        browser.driver.delete_all_cookies()
        browser.open(f"{self.address}/")
        browser.run("localStorage.setItem('language', arguments[0])", language)
        browser.open(f"{self.address}/")
        self.fill_in(name)

    def fill_in(self, name: str) -> None:
        """Log in by the form that is shown."""
        browser = self.browser
        browser.write("input[name=name]", name)
        browser.write("input[name=password]", PASSWORD)
        browser.press("form button.primary")
        browser.find("#state")

    def show(self, page: str) -> None:
        """Choose a page."""
        self.browser.run("location.hash = arguments[0]", page)
        self.browser.wait(
            lambda: self.browser.run("return document.body.dataset.page") == page,
            f"{page} is shown",
        )

    def wait_for_state(self, state: str) -> None:
        """Return when the band shows a state of the robot."""

        def is_so() -> bool:
            return self.browser.text("#state").startswith(state)

        self.browser.wait(is_so, f"the state is {state}", 60.0)


@contextlib.contextmanager
def launched_site(folder: Path, time_scale: int) -> Iterator[Site]:
    """Yield the page of a robot that runs so many times as fast, when the page answers.

    Its port is taken until every other part of the robot is there, and the page has said so.
    """
    port = free_port()
    config = folder / "config"
    write_config(config, folder / "page", port)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_MASTER_URI", "")
        patch.setenv("GPR20_STATE", "")
        # Other tests of this process find rospy as if there had been no node.
        for owner, name in NODE_STATE:
            patch.setattr(owner, name, getattr(owner, name))
        arguments = (f"time_scale:={time_scale}", "web:=true", f"config:={config}")
        robot = LaunchedRobot(folder, *arguments)
        try:
            with socket.create_server(("127.0.0.1", port)):
                robot.start()
                deadline_s = time.monotonic() + TAKEN_LIMIT_S
                while TAKEN not in (folder / "launch.log").read_text():
                    assert time.monotonic() < deadline_s, "the page does not begin"
                    time.sleep(0.1)
            # The page believes the window alone, and by its name.
            rospy.init_node("user_interface", disable_signals=True)
            site = Site(robot, f"https://localhost:{port}", folder)
            try:
                # Of all nodes it is the last to begin.
                site.browser.wait(site.opens, "the page answers")
                yield site
            finally:
                site.browser.close()
                site.screen.close()
        finally:
            rospy.signal_shutdown("the tests are over")
            robot.stop()
            # Of every new socket of the process, set when a topic was connected.
            socket.setdefaulttimeout(None)
