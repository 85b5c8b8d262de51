"""What the window asks its robot for, and which robot that is."""

import pytest
from view_kit import snapshot, state_of
from window_helpers import click, hold_to_start, show, start

from gpr20_common.message import verbatim
from gpr20_operator.robot.events import (
    Answer,
    Request,
)
from gpr20_operator.robot.snapshot import SurveyModel
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_survey.plan.survey_state import SurveyState


class Asked:
    """In place of a client: remembers what it is asked for."""

    def __init__(self):
        self.asked = []

    def __getattr__(self, name):
        return lambda *given, **more: self.asked.append((name, *given, *filter(more.get, more)))


@pytest.fixture
def parts(opened, clock):
    control = Asked()
    window = opened(survey=WindowPresenter(SurveyModel(clock), control, Asked()))
    window.begin()
    yield window, control
    window.end()


def state(code):
    return state_of(code, simulated=False)


def said(window, code):
    window.on_event(state(code))
    window.refresh()


def test_one_press_of_start_is_one_request_and_what_fails_is_said_once(parts):
    window, control = parts
    assert control.asked == [("check_master",)]
    said(window, SurveyState.IDLE)
    start(window)
    start(window)
    assert len(control.asked) == 2
    _name, plan = control.asked[1]
    assert plan.parameters.x_points == 11 and plan.permittivity == 4.0
    assert window.top_bar.stop.isEnabled()
    window.on_event(Answer(Request.START, True, verbatim(""), "id"))
    # It is accepted, and fails in its checks.
    failed = state_of(SurveyState.FAILED, "the disk is full; make space")
    window.on_event(state(SurveyState.CHECKING))
    assert not window.notice.isVisible()
    window.on_event(failed)
    window.refresh()
    assert window.notice.isVisible()
    assert window.notice.title.text() == "The survey has FAILED."
    assert "The disk is full" in window.notice.reason.toPlainText()
    click(window.notice.close_button)
    window.on_event(failed)
    window.refresh()
    assert not window.notice.isVisible()


def test_pause_resume_and_every_press_of_stop_are_asked_for(parts):
    window, control = parts
    said(window, SurveyState.SURVEYING)
    click(window.top_bar.pause)
    window.on_event(Answer(Request.PAUSE, True, verbatim("")))
    said(window, SurveyState.PAUSED)
    click(window.top_bar.pause)
    hold_to_start(window)
    click(window.top_bar.stop)
    click(window.top_bar.stop)
    resumed = ("resume_survey", "")
    assert control.asked[1:] == [("pause_survey",), resumed, ("stop",), ("stop",)]


OTHER = "Anritsu,MS2026C/2,62011033,1.23"
REFUSED = Answer(
    Request.RESUME,
    False,
    verbatim(f"the VNA is {OTHER}, but the survey was measured with Anritsu,MS2026C/2,1,1.23"),
    other_analyzer=OTHER,
)


def test_another_vna_is_a_question_that_resumes_the_same_survey_with_it(parts):
    window, control = parts
    sheet = window.start_sheet
    folder, asked = "20260921T141320_0f8fad5b", [("check_master",)]
    window.on_event(state(SurveyState.PAUSED))
    for accepted in (False, True):
        window.survey.resume(folder)
        # The status of the failed check may come first.
        window.on_event(state(SurveyState.CHECKING))
        window.on_event(state(SurveyState.PAUSED))
        window.on_event(REFUSED)
        asked.append(("resume_survey", folder))
        assert sheet.isVisible() and not window.notice.isVisible()
        assert sheet.question.rows[0][1] == REFUSED.message
        hold_to_start(window) if accepted else click(sheet.cancel)
        assert not sheet.isVisible() and (accepted or control.asked == asked)
    assert control.asked == [*asked, ("resume_survey", folder, OTHER)]
    # Another refusal after the question is a notice.
    window.on_event(Answer(Request.RESUME, False, verbatim("the VNA does not answer")))
    assert window.notice.reason.toPlainText() == "The VNA does not answer"
    assert window.notice.isVisible() and not sheet.isVisible()


def test_the_band_names_the_robot_that_stop_stops(opened):
    window = opened()
    for name, begin in (("", ""), ("robot1", "robot1: "), ("a" * 20 + "/1", f"…{'a' * 13}/1: ")):
        window.top_bar.show_robot(name)
        show(window, snapshot(SurveyState.SURVEYING))
        shown = window.top_bar.band.message.text()
        assert shown.startswith(begin) and (": " in shown) is bool(name)
