from dataclasses import replace

import pytest
from view_kit import state_of
from window_helpers import click, enter, hold_to_start, start

from gpr20_common.message import verbatim
from gpr20_operator.plan.preview import CostEstimated
from gpr20_operator.robot.events import (
    Answer,
    AxisLimits,
    Request,
    RobotFigures,
)
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.plan.survey_cost import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState


class Asked:
    """In place of a client: remembers what it is asked for."""

    def __init__(self):
        self.asked = []

    def __getattr__(self, name):
        return lambda *given, **more: self.asked.append((name, *given, *filter(more.get, more)))


@pytest.fixture
def estimator():
    return Asked()


@pytest.fixture
def parts(opened, clock, estimator):
    control = Asked()
    window = opened(survey=WindowPresenter(SurveyModel(clock), control, estimator))
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
    _name, parameters, _annotation, _refines, permittivity = control.asked[1]
    assert parameters.x_points == 11 and permittivity == window.control.permittivity == 4.0
    assert window.top_bar.stop.isEnabled()
    window.on_event(Answer(Request.START, True, verbatim(""), "id"))
    # It is accepted, and fails in its checks.
    failed = state_of(SurveyState.FAILED, "the disk is full; make space")
    window.on_event(state(SurveyState.CHECKING))
    assert not window.notice.isVisible()
    window.on_event(failed)
    assert window.notice.isVisible()
    assert window.notice.title.text() == "The survey was not started."
    assert "The disk is full" in window.notice.reason.toPlainText()
    click(window.notice.close_button)
    window.on_event(failed)
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


@pytest.mark.parametrize("folder", ["", "20260921T141320_0f8fad5b"])
def test_another_vna_is_a_question_that_resumes_the_same_survey_with_it(parts, folder):
    window, control = parts
    window.on_event(state(SurveyState.PAUSED))
    window.survey.resume(folder)
    # The status of the failed check may come first.
    window.on_event(state(SurveyState.CHECKING))
    window.on_event(state(SurveyState.PAUSED))
    window.on_event(REFUSED)
    assert window.question.isVisible() and not window.notice.isVisible()
    assert window.question.reason.toPlainText()[1:] == str(REFUSED.message)[1:]
    assert OTHER in window.question.details.toPlainText()
    click(window.question.close_button)
    assert not window.question.isVisible() and len(control.asked) == 2
    window.survey.resume(folder)
    window.on_event(REFUSED)
    click(window.question.accept_button)
    assert not window.question.isVisible()
    assert len(control.asked) == 3
    hold_to_start(window)
    asked = ("resume_survey", folder)
    assert control.asked[1:] == [asked, asked, (*asked, OTHER)]
    window.on_event(Answer(Request.RESUME, True, verbatim("")))
    assert not window.notice.isVisible() and not window.question.isVisible()
    # Another refusal after the question is a notice.
    window.on_event(Answer(Request.RESUME, False, verbatim("the VNA does not answer")))
    window.refresh()
    assert window.top_bar.pause.isEnabled()
    assert window.notice.reason.toPlainText() == "The VNA does not answer"
    assert window.notice.isVisible() and not window.question.isVisible()


def test_figures_of_the_robot_complete_the_preview(parts, estimator):
    window, _ = parts
    figures = RobotFigures("the robot", "its settings")
    assert estimator.asked == []
    window.on_event(AxisLimits(None, figures=figures))
    window.refresh()
    asked = window.control.parameters
    assert estimator.asked == [("ask", asked, figures)]
    # What was overtaken by another question is not shown.
    window.on_event(CostEstimated(replace(asked, x_points=99), SurveyCost(60.0, 10**9)))
    window.refresh()
    assert window.control.check_plan.lines[1].whole == ""
    window.on_event(CostEstimated(asked, SurveyCost(60.0, 10**9)))
    window.refresh()
    assert window.control.check_plan.lines[1].whole == "1 GB"
    enter(window, "x_points", "7")
    assert estimator.asked[-1] == ("ask", replace(asked, x_points=7), figures)
    assert window.control.check_plan.lines[1].whole == ""
