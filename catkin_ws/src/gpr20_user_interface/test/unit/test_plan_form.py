"""The form of the plan: what follows from what, its tiles, and what the survey will cost."""

import random
import threading
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from run_seed import draws
from survey_examples import AXES
from view_kit import TRAVEL as ROBOT
from view_kit import past_survey, snapshot

from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.form import PlanForm, points_for
from gpr20_operator.plan.preview import (
    CostEstimated,
    CostEstimator,
    preview,
)
from gpr20_operator.plan.tiles import resumable, spacing_warning
from gpr20_operator.robot.events import RobotFigures
from gpr20_survey.plan.imported import IMPORTED
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import survey_cost
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState

FIGURES = RobotFigures(RobotConfig(AXES, False), SurveySettings())


@pytest.fixture
def form():
    return PlanForm(ROBOT)


def cost_of(parameters):
    return survey_cost(parameters, FIGURES.config, FIGURES.settings)


def test_the_plan_of_a_new_robot_gives_no_warning_and_takes_a_quarter_of_an_hour(form):
    check = form.check()
    known = preview(check.parameters, check.permittivity)
    assert spacing_warning(known) is None
    assert max(known.x_spacing_mm, known.y_spacing_mm) <= known.quarter_wavelength_mm
    assert 600.0 < cost_of(check.parameters).duration_s < 900.0


def test_of_the_cost_only_the_newest_question_is_answered_and_nothing_after_the_end():
    received, answered = [], threading.Event()
    asked = [replace(default_parameters(), x_points=points) for points in range(3, 30)]
    newest = CostEstimated(asked[-1], cost_of(asked[-1]))

    def tell(event):
        received.append(event)
        if event == newest:
            answered.set()

    estimator = CostEstimator(tell)
    for parameters in asked:
        estimator.ask(parameters, FIGURES)
    assert answered.wait(30.0)
    estimator.close()
    before = len(received)
    estimator.ask(asked[0], FIGURES)
    for thread in threading.enumerate():
        if thread.name == "CostEstimator._estimate":
            thread.join(30.0)
    assert len(received) == before


def test_points_follow_the_spacing_and_the_area_until_they_are_set(form):
    form.set_texts({"x_spacing_mm": "10", "x_start_mm": "0", "x_stop_mm": "300"})
    for name, text, points, spacing in (
        *(("x_stop_mm", "305", "32", "10"), ("x_spacing_mm", "12,5", "26", "12,5")),
        *(("x_points", "6", "6", "61"), ("x_stop_mm", "350", "6", "70")),
        ("x_spacing_mm", "20", "19", "20"),
    ):
        form.set_text(name, text)
        assert (form.texts["x_points"], form.texts["x_spacing_mm"]) == (points, spacing)


@given(st.floats(0.5, 60.0), st.floats(1.0, 800.0))
def test_no_two_points_are_farther_apart_than_the_spacing(spacing_mm, length_mm):
    count = points_for(length_mm, spacing_mm)
    assert length_mm / (count - 1) <= spacing_mm * 1.00002
    assert count == 3 or length_mm / (count - 2) > spacing_mm


def test_a_profile_is_measured_as_it_is_whatever_its_spacing():
    draw = random.Random(2)
    for _ in range(draws(10)):
        form, other = PlanForm(ROBOT), PlanForm(ROBOT)
        form.set_text("x_start_mm", str(draw.randint(0, 300)))
        form.set_text("x_stop_mm", f"{draw.uniform(301, 650):.2f}")
        form.set_text("x_points", str(draw.randint(3, 400)))
        wanted = form.check().parameters
        other.show_parameters(wanted)
        assert other.check().parameters == wanted
        # The spacing gives the same points again.
        other.set_text("x_stop_mm", other.texts["x_stop_mm"])
        assert other.check().parameters == wanted


def test_only_the_last_survey_is_offered_and_only_if_it_ended_early_and_can_be_resumed():
    idle, early, older = snapshot(SurveyState.IDLE), past_survey(), past_survey(folder="2025")
    complete, imported = past_survey(complete=True), past_survey(outcome=IMPORTED, folder="2027")
    for listed, expected in (((), None), ((imported, early), early), ((complete, older), None)):
        past = PastSurveys()
        past.take("", listed, False)
        assert resumable(past, idle) == expected
        for other in (None, snapshot(SurveyState.IDLE, alive=False), snapshot(SurveyState.HOMING)):
            assert resumable(past, other) is None
        past.set_running("another")
        assert resumable(past, idle) is None
