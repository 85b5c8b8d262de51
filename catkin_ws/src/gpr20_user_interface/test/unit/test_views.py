import os

import pytest

pytest.importorskip("PyQt5")
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QLabel, QLineEdit, QMessageBox, QPushButton

from gpr20_main_control.mid.survey_parameters import RobotTravel, Travel
from gpr20_main_control.mid.survey_state import SurveyState
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.survey_state import (
    ControlState,
    CurrentPosition,
    Progress,
    Request,
    TargetPosition,
)
from gpr20_user_interface.mid.views.main_window import MainWindow
from gpr20_user_interface.mid.views.style import COMMAND_PX, TOUCH_PX

ROBOT = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))


@pytest.fixture(scope="module")
def application():
    yield QApplication.instance() or QApplication([])


@pytest.fixture
def window(application):
    window = MainWindow()
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
        "started_here": True,
        **other,
    }
    return Snapshot(**values)


def wishes(window):
    heard = []
    window.start_requested.connect(heard.append)
    window.stop_requested.connect(lambda: heard.append("stop"))
    window.resume_requested.connect(lambda: heard.append("resume"))
    return heard


def enter(window, name, text):
    window.form.edit(name).selectAll()
    QTest.keyClicks(window.form.edit(name), text)


def click(button):
    QTest.mouseClick(button, Qt.LeftButton)


def test_start_carries_what_the_operator_entered(window):
    heard = wishes(window)
    window.refresh(snapshot(SurveyState.IDLE))
    enter(window, "x_points", "7")
    enter(window, "start_frequency_hz", "700.5")
    click(window.commands.start)
    assert (heard[0].x_points, heard[0].start_frequency_hz) == (7, 700.5e6)


def test_wrong_field_turns_says_what_is_allowed_and_locks_start(window):
    heard = wishes(window)
    window.refresh(snapshot(SurveyState.IDLE))
    edit = window.form.edit("x_stop_mm")
    right = edit.grab().toImage().pixelColor(60, 8)
    enter(window, "x_stop_mm", "651")
    assert edit.grab().toImage().pixelColor(60, 8) != right
    assert "between 0 and 650 mm" in window.problems.toPlainText()
    assert "between 0 and 650 mm" in edit.toolTip()
    click(window.commands.start)
    assert heard == []
    enter(window, "x_stop_mm", "650")
    assert window.problems.toPlainText() == ""
    click(window.commands.start)
    assert len(heard) == 1


def test_limits_that_become_known_are_applied_to_what_stands_there(window):
    enter(window, "x_stop_mm", "700")
    window.refresh(snapshot(SurveyState.IDLE, travel=None))
    assert window.commands.start.isEnabled()
    window.refresh(snapshot(SurveyState.IDLE))
    assert not window.commands.start.isEnabled()


def test_parameters_of_somebody_elses_survey_are_not_claimed_to_be_known(window):
    window.refresh(snapshot(SurveyState.SURVEYING, started_here=False))
    assert "was not started here" in window.problems.toPlainText()
    window.refresh(snapshot(SurveyState.SURVEYING))
    assert window.problems.toPlainText() == ""
    window.refresh(snapshot(SurveyState.FINISHED, started_here=False))
    assert window.problems.toPlainText() == ""


def test_stop_and_resume_are_told(window):
    heard = wishes(window)
    window.refresh(snapshot(SurveyState.PAUSED))
    click(window.commands.stop)
    click(window.commands.resume)
    assert heard == ["stop", "resume"]


@pytest.mark.parametrize("code", list(SurveyState))
def test_title_is_what_main_control_says(window, code):
    window.refresh(snapshot(code))
    assert window.status.title == code.name
    assert window.status.message == "as it is"


def test_progress_is_shown_and_never_full_before_the_end(window):
    progress = Progress("id", 99.999, 20000, 19999, 1128.0)
    window.refresh(snapshot(SurveyState.SURVEYING, progress=progress))
    assert window.progress.thousandths == 999
    assert window.progress.texts == "19999 of 20000 traces\n0d:0h:18m:48s remaining (measured)"
    window.refresh(snapshot(SurveyState.SURVEYING, progress=Progress("id", 0.0, 18, 0, 60.0)))
    assert "0d:0h:1m:0s remaining (by the plan)" in window.progress.texts


def test_positions_are_shown_or_said_to_be_unknown(window):
    window.refresh(
        snapshot(
            SurveyState.SURVEYING,
            current=CurrentPosition(1.0, 2.5, -90.0),
            target=TargetPosition(650.0, 800.0, 90.0),
            height_m=0.3121,
        )
    )
    cells = [window.positions.cell("current", column) for column in range(1, 5)]
    assert cells == ["1.00", "2.50", "-90.00", "0.312"]
    assert window.positions.cell("target", 1) == "650.00"
    window.refresh(snapshot(SurveyState.IDLE))
    assert window.positions.cell("current", 1) == window.positions.cell("current", 4) == "—"


def test_absence_and_simulation_cannot_be_overlooked(window):
    window.refresh(snapshot(SurveyState.SURVEYING))
    assert window.banners.texts == "SIMULATED robot: these data show no real ground"
    window.refresh(snapshot(SurveyState.SURVEYING, alive=False))
    assert "main_control not heard for 7 s: the robot may still move" in window.banners.texts
    window.refresh(snapshot(None, alive=False, control_silent_s=None))
    assert "roslaunch gpr20 survey.launch" in window.banners.texts
    assert "SIMULATED" not in window.banners.texts


@pytest.mark.parametrize("request_", list(Request))
def test_refusal_is_a_dialog_that_leaves_the_window_usable(window, request_):
    heard = wishes(window)
    window.refresh(snapshot(SurveyState.SURVEYING))
    window.show_refusal(request_, "<b>the reason</b>")
    dialog = window.findChild(QMessageBox)
    assert dialog.isVisible() and not dialog.isModal()
    assert dialog.informativeText() == "<b>the reason</b>"
    assert dialog.textFormat() == Qt.PlainText
    click(window.commands.stop)
    assert heard == ["stop"]
    dialog.close()


def busiest(window):
    long = "the VNA at 192.168.100.100 does not answer; check its cable and its address. " * 8
    enter(window, "vna_address", "192.168.100.1000")
    enter(window, "x_stop_mm", "50.001")
    enter(window, "polarizations_deg", "0, 0")
    window.refresh(
        snapshot(
            SurveyState.CONFIGURED,
            alive=False,
            control_silent_s=None,
            state=ControlState(SurveyState.CONFIGURED, long, "id", True),
            progress=Progress("id", 99.9, 1000000, 999999, 10**7),
            current=CurrentPosition(650.0, 800.0, -90.0),
            target=TargetPosition(650.0, 800.0, -90.0),
            height_m=0.123,
        )
    )
    QTest.qWait(1)


def test_nothing_is_cut_off_on_the_small_screen(window):
    busiest(window)
    assert (window.width(), window.height()) == (800, 480)
    shown = [one for kind in (QLabel, QPushButton, QLineEdit) for one in window.findChildren(kind)]
    for widget in filter(lambda one: one.isVisible(), shown):
        corner = widget.mapTo(window, widget.rect().bottomRight())
        assert corner.x() < 800 and corner.y() < 480, widget.objectName()
        text = widget.text().replace("&", "")
        if not (isinstance(widget, QLabel) and widget.wordWrap()):
            assert widget.fontMetrics().horizontalAdvance(text) <= widget.width(), text
    assert window.banners.heightForWidth(window.banners.width()) <= window.banners.height()


def test_long_sentences_can_be_scrolled_to(window):
    busiest(window)
    for text in (window.problems, window.findChild(type(window.problems), "status_message")):
        assert text.height() >= 2 * text.fontMetrics().height()
        assert text.verticalScrollBarPolicy() == Qt.ScrollBarAsNeeded


def test_everything_to_touch_is_large_enough_for_a_glove(window):
    window.refresh(snapshot(SurveyState.IDLE))
    assert all(edit.height() >= TOUCH_PX for edit in window.findChildren(QLineEdit))
    assert all(button.height() >= COMMAND_PX for button in window.findChildren(QPushButton))
