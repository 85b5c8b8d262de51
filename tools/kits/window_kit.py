"""The whole simulated robot on a master of its own, and the real window on a screen of its own."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import time
from pathlib import Path
from subprocess import DEVNULL
from typing import Any, Callable, Iterator, List

import rospy
from PyQt5.QtCore import QEventLoop, QTimer
from robot_kit import running

from gpr20_common.high.service_client import ServiceClient
from gpr20_msgs.msg import ControlStatus, SurveyParameters
from gpr20_msgs.srv import Command, SetSurveyParameters, StartSurvey
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.low.settings_file import SettingsFile

# Homing from the far end of an axis takes more than a minute.
TIME_LIMIT_S = 180.0
SCREEN = "800x480x24"


@contextlib.contextmanager
def virtual_screen(size: str = SCREEN) -> Iterator[None]:
    """Let Qt draw on an X server of its own.

    Args:
        size: Width, height and depth of the screen [pixels, bits].
    """
    program = shutil.which("Xvfb")
    if program is None:
        raise SystemExit("Xvfb is missing; run scripts/setup.sh --dev")
    reading, writing = os.pipe()
    command = [program, "-displayfd", str(writing), "-screen", "0", size, "-nolisten", "tcp"]
    with running(*command, end_by=signal.SIGTERM, pass_fds=[writing], stderr=DEVNULL):
        os.close(writing)
        with os.fdopen(reading) as answer:
            os.environ["DISPLAY"] = f":{answer.readline().strip()}"
        os.environ["QT_QPA_PLATFORM"] = "xcb"
        yield


def new_window(languages: Languages, folder: Path, replay: bool = False) -> UserInterface:
    """Return the whole window.

    Args:
        languages: Its languages.
        folder: Of what it remembers.
        replay: Whether it shows a replay in place of a robot.
    """
    settings = SettingsFile(folder / "plan.yaml")
    return UserInterface(replay, languages, settings)


class Operator:
    """Starts surveys through the services, as another window would, and follows their progress."""

    def __init__(self) -> None:
        self.code = -1
        self._subscriber = rospy.Subscriber("control_status", ControlStatus, self._note)

    def call(self, name: str, kind: Any, **fields: Any) -> Any:
        """Call a service that must succeed; return its answer."""
        answer = ServiceClient(name, kind).call(TIME_LIMIT_S, **fields)
        if not answer.success:
            raise SystemExit(f"{name} was refused: {answer.message}")
        return answer

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
        plan = self.call("set_survey_parameters", SetSurveyParameters, parameters=parameters)
        self.call("start_survey", StartSurvey, plan_id=plan.plan_id)

    def pause(self) -> None:
        """Ask to pause."""
        self.call("pause_survey", Command)

    def stop(self) -> None:
        """Ask to stop."""
        self.call("stop_survey", Command)

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
