import pytest

pytest.importorskip("PyQt5")

from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QPushButton
from window_helpers import application, click, show, snapshot, window, wishes

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import Progress, Request
from gpr20_user_interface.mid.robot_health import Alarm, AlarmKind
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.notice import NoticeKind
from gpr20_user_interface.views.style import TOUCH_PX

__all__ = ["application", "window"]


@pytest.mark.parametrize("tab", [TabName.CONTROL, TabName.STATUS])
def test_stop_is_one_touch_from_every_tab(window, tab):
    heard = wishes(window)
    show(window, snapshot(SurveyState.SURVEYING))
    window.show_tab(tab)
    click(window.top_bar.stop)
    assert heard == ["stop"]


def test_stop_is_told_at_the_touch_and_not_when_the_finger_leaves(window):
    heard = wishes(window)
    show(window, snapshot(SurveyState.SURVEYING))
    QTest.mousePress(window.top_bar.stop, 1)
    assert heard == ["stop"]
    QTest.mouseRelease(window.top_bar.stop, 1)
    assert heard == ["stop"]


@pytest.mark.parametrize("code", list(SurveyState))
def test_stop_can_be_pressed_while_there_may_be_something_to_stop(window, code):
    show(window, snapshot(code))
    assert window.top_bar.stop.isEnabled() is code.running
    show(window, snapshot(code, alive=False))
    assert window.top_bar.stop.isEnabled()


def test_state_and_progress_are_seen_from_every_tab(window):
    show(window, snapshot(SurveyState.SURVEYING, progress=Progress("id", 99.99, 90, 89, 1.0)))
    assert window.top_bar.title.text() == "SURVEYING  99.9 %"
    assert window.top_bar.message.whole == "as it is"
    assert window.top_bar.simulated.isVisible()


@pytest.mark.parametrize(
    ("alarm", "words"),
    [
        (Alarm(AlarmKind.MASTER_GONE), "ROS master does not answer: the robot may still move"),
        (Alarm(AlarmKind.CONTROL_NEVER_HEARD), "roslaunch gpr20 survey.launch"),
        (Alarm(AlarmKind.CONTROL_SILENT, 7.9), "not heard for 7 s: the robot may still move"),
        (Alarm(AlarmKind.SURVEY_INTERRUPTED), "the survey is INTERRUPTED. SURVEYS resumes it"),
        (Alarm(AlarmKind.ANALYZER_GONE, detail="no answer"), "VNA is in trouble: no answer"),
    ],
)
def test_alarm_cannot_be_overlooked_and_goes_when_its_cause_goes(window, alarm, words):
    show(window, snapshot(SurveyState.SURVEYING, alarm=alarm))
    assert window.top_bar.alarm.isVisible()
    assert words in window.top_bar.alarm.text()
    # What the robot did last is still seen.
    assert window.top_bar.title.text() == "SURVEYING"
    show(window, snapshot(SurveyState.SURVEYING))
    assert not window.top_bar.alarm.isVisible()


@pytest.mark.parametrize("request_", list(Request))
def test_refusal_is_a_dialog_with_reason_and_next_step_that_leaves_stop_free(window, request_):
    heard = wishes(window)
    show(window, snapshot(SurveyState.SURVEYING))
    window.notice.show_notice(NoticeKind[request_.name], "<b>the reason</b>")
    assert window.notice.isVisible()
    assert window.notice.reason.toPlainText() == "<b>the reason</b>"
    assert window.notice.next_step.text().startswith("Next: ")
    assert not window.notice.geometry().intersects(window.top_bar.geometry())
    click(window.top_bar.stop)
    assert heard == ["stop"]
    click(window.notice.close_button)
    assert not window.notice.isVisible()


def test_everything_to_touch_is_large_enough_for_a_glove(window):
    for tab in (TabName.CONTROL, TabName.STATUS):
        window.show_tab(tab)
        show(window, snapshot(SurveyState.IDLE))
        touched = [one for one in window.findChildren(QPushButton) if one.isVisible()]
        touched += [one for one in window.control.form.edits() if one.isVisible()]
        for widget in touched:
            assert min(widget.height(), widget.width()) >= TOUCH_PX, widget.objectName()
    assert window.tabs.tabBar().height() >= TOUCH_PX
