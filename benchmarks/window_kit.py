"""The whole simulated robot on a master of its own, and the real window on a screen of its own."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Iterator, List, Optional

import rospy
from PyQt5.QtCore import QEventLoop, QTimer
from std_srvs.srv import Trigger

from gpr20_common.high.service_client import ServiceClient
from gpr20_common.low.clock import Clock
from gpr20_msgs.msg import ControlStatus, SurveyParameters
from gpr20_msgs.srv import SetSurveyParameters, StartSurvey
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.low.profile_folder import ProfileFolder
from gpr20_user_interface.mid.profiles import Profiles
from gpr20_user_interface.mid.survey_model import SurveyModel
from gpr20_user_interface.views.translation import Languages

TIME_LIMIT_S = 60.0
SCREEN = "800x480x24"


@contextlib.contextmanager
def ended(child: subprocess.Popen, how: signal.Signals) -> Iterator[subprocess.Popen]:
    """End a process in the end."""
    try:
        yield child
    finally:
        child.send_signal(how)
        child.wait(TIME_LIMIT_S)


@contextlib.contextmanager
def virtual_screen() -> Iterator[None]:
    """Let Qt draw on an X server of its own."""
    program = shutil.which("Xvfb")
    if program is None:
        raise SystemExit("Xvfb is missing; run scripts/setup.sh --dev")
    reading, writing = os.pipe()
    command = [program, "-displayfd", str(writing), "-screen", "0", SCREEN, "-nolisten", "tcp"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with ended(subprocess.Popen(command, pass_fds=[writing], **quiet), signal.SIGTERM):
        os.close(writing)
        with os.fdopen(reading) as answer:
            os.environ["DISPLAY"] = f":{answer.readline().strip()}"
        os.environ["QT_QPA_PLATFORM"] = "xcb"
        yield


@contextlib.contextmanager
def simulated_robot(*arguments: str) -> Iterator[Path]:
    """Launch the robot on a free port; yield the folder of its surveys, which is removed."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    folder = Path(tempfile.mkdtemp(prefix="gpr20_window_"))
    command = ["roslaunch", "-p", str(port), "gpr20", "survey.launch", "ui:=false"]
    command += [f"data:={folder / 'data'}", *arguments]
    with (folder / "roslaunch.log").open("wb") as log:
        child = subprocess.Popen(command, start_new_session=True, stdout=log, stderr=log)
    try:
        with ended(child, signal.SIGINT):
            yield folder / "data"
    finally:
        shutil.rmtree(str(folder))


def new_window(languages: Languages, folder: Path) -> UserInterface:
    """Return the whole window; its profiles are below a folder."""
    profiles = Profiles(ProfileFolder(folder / "profiles"))
    return UserInterface(SurveyModel(Clock()), languages, profiles)


class Operator:
    """Starts surveys through the services, as another window would, and hears how they go."""

    def __init__(self) -> None:
        self.code = -1
        self._subscriber = rospy.Subscriber("control_status", ControlStatus, self._note)

    def call(self, name: str, kind: Any, **fields: Any) -> None:
        """Call a service that must succeed."""
        answer = ServiceClient(name, kind).call(TIME_LIMIT_S, **fields)
        if not answer.success:
            raise SystemExit(f"{name} was refused: {answer.message}")

    def start(self, **changes: Any) -> None:
        """Start a survey over the two targets; changes are fields of SurveyParameters."""
        values = {
            "vna_address": "127.0.0.1",
            "start_frequency_hz": 600e6,
            "stop_frequency_hz": 6e9,
            "frequency_points": 201,
            **{"x_start_mm": 50.0, "x_stop_mm": 350.0, "x_points": 21},
            **{"y_start_mm": 50.0, "y_stop_mm": 350.0, "y_points": 21},
            "polarizations_deg": [0.0, 90.0],
        }
        parameters = SurveyParameters(**{**values, **changes})
        self.call("set_survey_parameters", SetSurveyParameters, parameters=parameters)
        self.call("start_survey", StartSurvey)

    def pause(self) -> None:
        """Ask to pause."""
        self.call("pause_survey", Trigger)

    def stop(self) -> None:
        """Ask to stop."""
        self.call("stop_survey", Trigger)

    def _note(self, message: ControlStatus) -> None:
        self.code = message.code


def run_events(duration_s: float) -> None:
    """Let the window live for a while.

    Raises:
        KeyboardInterrupt: Ctrl-C; raised in a slot, as by default, it would change nothing.
    """
    loop = QEventLoop()
    interrupts: List[int] = []

    def leave(number: int, _frame: object) -> None:
        interrupts.append(number)
        loop.quit()

    former = signal.signal(signal.SIGINT, leave)
    try:
        QTimer.singleShot(round(duration_s * 1000), loop.quit)
        loop.exec_()
    finally:
        signal.signal(signal.SIGINT, former)
    if interrupts:
        raise KeyboardInterrupt


def run_until(condition: Callable[[], bool], what: str, limit_s: float) -> None:
    """Let the window live until a condition holds."""
    deadline_s = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > deadline_s:
            raise SystemExit(f"not within {limit_s:g} s: {what}")
        run_events(0.05)


def resident_mb(pid: Optional[int] = None) -> float:
    """Return the memory that a process has in use [MB]."""
    lines: List[str] = Path(f"/proc/{pid or 'self'}/status").read_text().splitlines()
    line = next(one for one in lines if one.startswith("VmRSS"))
    return float(line.split()[1]) / 1024.0
