"""Estimates of time and size."""

import pytest
from survey_examples import PARAMETERS, TRAVEL

from gpr20_survey.plan.survey_estimate import (
    MeasuringTimes,
    RemainingTime,
    needed_bytes,
    point_durations_s,
)
from gpr20_survey.plan.survey_plan import survey_points


def test_a_point_takes_the_longest_of_its_moves_and_the_measurement():
    points = survey_points(PARAMETERS, TRAVEL)
    times = MeasuringTimes(settle_s=0.5, height_s=0.4, frequency_points=4000)
    durations = point_durations_s(points, lambda axis_id, distance: abs(distance), times)
    assert durations[0] == pytest.approx(10.0 + 0.5 + 1.4)
    assert durations[1] == pytest.approx(90.0 + 0.5 + 1.4)
    assert len(durations) == len(points)


def test_before_the_first_point_the_remaining_time_is_the_plan():
    assert RemainingTime([10.0, 20.0, 30.0]).remaining_s(0, 5.0) == 60.0


def test_the_remaining_time_follows_the_pace_so_far():
    assert RemainingTime([10.0, 20.0, 30.0]).remaining_s(1, 15.0) == pytest.approx(75.0)
    assert RemainingTime([10.0, 20.0, 30.0]).remaining_s(3, 90.0) == 0.0


def test_the_size_grows_with_traces_points_and_time():
    base = needed_bytes(18, 501, 100.0)
    assert needed_bytes(36, 501, 100.0) > base
    assert needed_bytes(18, 1001, 100.0) > base
    assert needed_bytes(18, 501, 1000.0) > base
