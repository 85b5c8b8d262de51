import os
import threading

import pytest

pytest.importorskip("PyQt5")
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtCore import QObject, Qt, pyqtSignal
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import Answer, ControlState, Progress, Request
from gpr20_user_interface.mid.survey_model import SurveyModel
from gpr20_user_interface.mid.window_presenter import WindowPresenter
from gpr20_user_interface.views.control_view import ControlView
from gpr20_user_interface.views.main_window import MainWindow, Tabs
from gpr20_user_interface.views.status_view import StatusView
from gpr20_user_interface.views.translation import Language


class ControlThatRecords:
    def __init__(self):
        self.asked = []

    def start_survey(self, parameters):
        self.asked.append(parameters)

    def stop_survey(self):
        self.asked.append("stop")

    def pause_survey(self):
        self.asked.append("pause")

    def resume_survey(self):
        self.asked.append("resume")

    def read_axis_limits(self):
        self.asked.append("limits")


class Link(QObject):
    event = pyqtSignal(object)


class WatchedModel(SurveyModel):
    def __init__(self, clock):
        super().__init__(clock)
        self.threads = []

    def handle(self, event):
        self.threads.append(threading.current_thread())
        super().handle(event)


@pytest.fixture(scope="module")
def application():
    yield QApplication.instance() or QApplication([])


@pytest.fixture
def parts(application, clock):
    window = MainWindow(Tabs(ControlView(), StatusView()), Language.ENGLISH)
    control, model = ControlThatRecords(), WatchedModel(clock)
    presenter = WindowPresenter(model, window, control)
    window.show()
    presenter.begin()
    yield presenter, window, control, model
    presenter.end()
    window.close()


def state(code):
    return ControlState(code, "as it is", "id", False)


def click(button):
    QTest.mouseClick(button, Qt.LeftButton)


def test_limits_of_the_axes_are_asked_for_at_once(parts):
    _, _, control, _ = parts
    assert control.asked == ["limits"]


def test_one_press_of_start_is_one_request(parts):
    presenter, window, control, _ = parts
    presenter.on_event(state(SurveyState.IDLE))
    presenter.refresh()
    click(window.control.start)
    click(window.control.start)
    assert len(control.asked) == 2
    assert control.asked[1].x_points == 5
    assert window.top_bar.stop.isEnabled()


def test_stop_can_be_pressed_again_until_the_robot_stops(parts):
    presenter, window, control, _ = parts
    presenter.on_event(state(SurveyState.SURVEYING))
    presenter.refresh()
    click(window.top_bar.stop)
    click(window.top_bar.stop)
    assert control.asked[1:] == ["stop", "stop"]


def test_resume_is_asked_for(parts):
    presenter, window, control, _ = parts
    presenter.on_event(state(SurveyState.PAUSED))
    presenter.refresh()
    click(window.control.pause)
    assert control.asked[1:] == ["resume"]


def test_pause_is_asked_for(parts):
    presenter, window, control, _ = parts
    presenter.on_event(state(SurveyState.SURVEYING))
    presenter.refresh()
    click(window.control.pause)
    assert control.asked[1:] == ["pause"]


def test_refused_request_opens_a_dialog_and_unlocks_start(parts):
    presenter, window, _, _ = parts
    presenter.on_event(state(SurveyState.CONFIGURED))
    presenter.refresh()
    click(window.control.start)
    assert not window.control.start.isEnabled()
    presenter.on_event(Answer(Request.START, False, "the disk is full"))
    assert window.notice.reason.toPlainText() == "the disk is full"
    assert window.notice.isVisible()
    assert window.control.start.isEnabled()


def test_granted_request_opens_no_dialog(parts):
    presenter, window, _, _ = parts
    presenter.on_event(Answer(Request.START, True, "", "id"))
    assert not window.notice.isVisible()


def test_events_of_other_threads_reach_the_window_in_its_own(parts):
    presenter, window, _, model = parts
    link = Link()
    link.event.connect(presenter.on_event, Qt.ConnectionType.QueuedConnection)
    events = [state(SurveyState.SURVEYING), Progress("id", 50.0, 18, 9, 30.0)]
    for event in events:
        thread = threading.Thread(target=link.event.emit, args=(event,))
        thread.start()
        thread.join()
    assert model.threads == []
    assert_within_5_s(lambda: window.status.progress.thousandths == 500)
    assert set(model.threads) == {threading.current_thread()}
    assert window.status.message.title == "SURVEYING"


def assert_within_5_s(condition):
    for _ in range(250):
        if condition():
            return
        QTest.qWait(20)
    raise AssertionError("not within 5 s")


def test_start_that_is_accepted_and_fails_in_its_checks_opens_a_dialog(parts):
    presenter, window, control, _ = parts
    presenter.on_event(state(SurveyState.CONFIGURED))
    presenter.refresh()
    click(window.control.start)
    presenter.on_event(Answer(Request.START, True, "started", "id"))
    presenter.on_event(state(SurveyState.CHECKING))
    assert not window.notice.isVisible()
    presenter.on_event(
        ControlState(SurveyState.FAILED, "the disk is full; make space", "id", False)
    )
    assert window.notice.isVisible()
    assert window.notice.title.text() == "The survey was not started."
    assert "the disk is full" in window.notice.reason.toPlainText()
    click(window.notice.close_button)
    presenter.on_event(
        ControlState(SurveyState.FAILED, "the disk is full; make space", "id", False)
    )
    assert not window.notice.isVisible()
