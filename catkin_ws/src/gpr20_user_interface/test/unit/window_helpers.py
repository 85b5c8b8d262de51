"""A window without ROS, and what its tests do with it."""

import os

import pytest

pytest.importorskip("PyQt5")
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from gpr20_survey.plan.survey_parameters import RobotTravel, Travel
from gpr20_user_interface.mid.events import ControlState
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.control_view import ControlView
from gpr20_user_interface.views.main_window import MainWindow, Tabs
from gpr20_user_interface.views.status_view import StatusView
from gpr20_user_interface.views.translation import Language

ROBOT = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))


@pytest.fixture(scope="session")
def application():
    yield QApplication.instance() or QApplication([])


@pytest.fixture
def window(application):
    window = MainWindow(Tabs(ControlView(), StatusView()), Language.ENGLISH)
    window.show()
    yield window
    window.close()


def snapshot(code=None, alive=True, **other):
    values = {
        "control_alive": alive,
        "control_silent_s": 0.1 if alive else 7.9,
        "state": None if code is None else ControlState(code, "as it is", "id", True),
        "progress": None,
        "current": None,
        "target": None,
        "height_m": None,
        "pending": frozenset(),
        "travel": ROBOT,
        **other,
    }
    return Snapshot(**values)


def wishes(window):
    heard = []
    window.start_requested.connect(heard.append)
    window.stop_requested.connect(lambda: heard.append("stop"))
    window.pause_requested.connect(lambda: heard.append("pause"))
    window.resume_requested.connect(lambda: heard.append("resume"))
    return heard


def enter(window, name, text):
    edit = window.control.form.edit(name)
    edit.selectAll()
    QTest.keyClicks(edit, text)


def click(button):
    QTest.mouseClick(button, Qt.LeftButton)
