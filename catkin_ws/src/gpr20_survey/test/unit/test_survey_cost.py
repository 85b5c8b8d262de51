from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from survey_examples import AXES

from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import axis_move_duration_s, move_durations, survey_cost
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_settings import SurveySettings

FACTS = RobotConfig(AXES, simulated=True)
PARAMETERS = SurveyParameters("127.0.0.1", 6.0e8, 6.0e9, 501, 50.0, 150.0, 5, 50.0, 150.0, 5)


def test_a_robot_that_runs_faster_needs_less_time_and_fewer_messages():
    slow = survey_cost(PARAMETERS, FACTS, SurveySettings())
    fast = survey_cost(PARAMETERS, replace(FACTS, time_scale=10.0), SurveySettings())
    assert fast.duration_s == pytest.approx(slow.duration_s / 10.0)
    assert 50 * 501 * 3 * 24 < fast.size_bytes < slow.size_bytes


def test_more_settling_costs_its_time_at_every_trace():
    cost = survey_cost(PARAMETERS, FACTS, SurveySettings(settle_s=0.0))
    settled = survey_cost(PARAMETERS, FACTS, SurveySettings(settle_s=3.0))
    assert settled.duration_s - cost.duration_s == pytest.approx(50 * 3.0)


@settings(max_examples=50)
@given(st.sampled_from(list(AxisId)), st.floats(min_value=-90.0, max_value=90.0))
def test_what_is_kept_of_a_distance_is_what_is_computed(axis_id, distance):
    kept = move_durations(FACTS.axes)
    expected_s = axis_move_duration_s(FACTS.axes[axis_id], distance)
    assert kept(axis_id, distance) == kept(axis_id, distance) == expected_s
