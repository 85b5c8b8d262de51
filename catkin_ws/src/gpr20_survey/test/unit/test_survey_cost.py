"""What a survey costs: time and size."""

from dataclasses import replace

import pytest
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from survey_examples import AXES, TRAVEL
from survey_examples import PARAMETERS as SMALL

from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import (
    MeasuringTimes,
    RemainingTime,
    axis_move_duration_s,
    move_durations,
    needed_bytes,
    planned_times,
    point_durations_s,
    survey_cost,
)
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.trace.ms2026c import sweep_duration_s
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings

CONFIG = RobotConfig(AXES, simulated=True)
PARAMETERS = SurveyParameters("127.0.0.1", 6.0e8, 6.0e9, 501, 50.0, 150.0, 5, 50.0, 150.0, 5)


def test_a_robot_that_runs_faster_needs_less_time_and_fewer_messages():
    slow = survey_cost(PARAMETERS, CONFIG, SurveySettings())
    fast = survey_cost(PARAMETERS, replace(CONFIG, time_scale=10.0), SurveySettings())
    assert fast.duration_s == pytest.approx(slow.duration_s / 10.0)
    assert 50 * 501 * 3 * 24 < fast.size_bytes < slow.size_bytes


def test_more_settling_costs_its_time_at_every_trace():
    cost = survey_cost(PARAMETERS, CONFIG, SurveySettings(settle_s=0.5))
    settled = survey_cost(PARAMETERS, CONFIG, SurveySettings(settle_s=3.5))
    assert settled.duration_s - cost.duration_s == pytest.approx(50 * 3.0)


@each_case(
    "analyzer, expected_s",
    [
        (AnalyzerSettings(), 501 * 350e-6),
        (AnalyzerSettings(100_000.0, 1), 501 * 350e-6),
        (AnalyzerSettings(10_000.0, 1), 501 * 350e-6),
        (AnalyzerSettings(20.0, 1), 501 * (350e-6 + 0.05 - 1e-4)),
        (AnalyzerSettings(20.0, 3), 3 * 501 * (350e-6 + 0.05 - 1e-4)),
        (AnalyzerSettings(averages=16), 16 * 501 * 350e-6),
    ],
)
def test_a_sweep_takes_longer_with_a_narrow_if_bandwidth_and_with_averages(analyzer, expected_s):
    duration_s = sweep_duration_s(SweepSettings(6.0e8, 6.0e9, 501, analyzer))
    assert duration_s == pytest.approx(expected_s)


def test_a_bandwidth_that_is_left_to_the_instrument_may_be_assumed_to_be_narrow():
    left, stated = (SweepSettings(6.0e8, 6.0e9, 501, AnalyzerSettings(hz)) for hz in (0.0, 10.0))
    assert sweep_duration_s(left, 1e-3, 10.0) == sweep_duration_s(stated, 1e-3)


def test_the_estimate_of_a_survey_follows_the_settings_of_the_analyzer():
    usual = survey_cost(PARAMETERS, CONFIG, SurveySettings())
    slow = survey_cost(
        replace(PARAMETERS, if_bandwidth_hz=20.0, averages=2), CONFIG, SurveySettings()
    )
    longer_s = slow.duration_s - usual.duration_s
    assert longer_s == pytest.approx(50 * 2 * 501 * 0.05, rel=0.02)
    assert slow.size_bytes > usual.size_bytes


def test_the_height_is_measured_while_vibrations_settle():
    cost = survey_cost(PARAMETERS, CONFIG, SurveySettings(settle_s=0.5, height_s=0.4))
    quick = survey_cost(PARAMETERS, CONFIG, SurveySettings(settle_s=0.5, height_s=0.0))
    slow = survey_cost(PARAMETERS, CONFIG, SurveySettings(settle_s=0.5, height_s=0.7))
    assert quick.duration_s == cost.duration_s
    assert slow.duration_s - cost.duration_s == pytest.approx(50 * 0.2)


@settings(max_examples=50)
@given(st.sampled_from(list(AxisId)), st.floats(min_value=-90.0, max_value=90.0))
def test_what_is_kept_of_a_distance_is_what_is_computed(axis_id, distance):
    kept = move_durations(CONFIG.axes)
    expected_s = axis_move_duration_s(CONFIG.axes[axis_id], distance)
    assert kept(axis_id, distance) == kept(axis_id, distance) == expected_s


def test_a_point_takes_the_longest_of_its_moves_and_the_measurement():
    points = survey_points(SMALL, TRAVEL)
    times = MeasuringTimes(settle_s=0.5, height_s=0.4, sweep=SweepSettings(6.0e8, 6.0e9, 4000))
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


def duration_of_moves(path):
    """Return how long moves through points take, each axis at its own duration [s]."""
    return sum(
        max(
            axis_move_duration_s(AXES[axis_id], getattr(after, name) - getattr(before, name))
            for axis_id, name in zip(AxisId, ("x_mm", "y_mm", "z_deg"))
        )
        for before, after in zip(path, path[1:])
    )


@pytest.mark.parametrize("interval_s", [15.0, 40.0, 70.0])
def test_the_visits_of_the_first_stop_are_part_of_the_planned_time(interval_s):
    without = SurveySettings(reference_interval_s=0.0)
    visiting = SurveySettings(reference_interval_s=interval_s)
    points = survey_points(SMALL, TRAVEL)
    alone = planned_times(points, SMALL.sweep_settings, CONFIG, without)
    times = planned_times(points, SMALL.sweep_settings, CONFIG, visiting)
    assert times.visits[-1] == len(points) and not any(one % 2 for one in times.visits)
    # What the robot does, written out: its way with every visit, and its sweeps.
    way, sweeps = [replace(points[0], x_mm=0.0, y_mm=0.0, z_deg=0.0)], 0
    for index in range(len(points) + 1):
        if index in times.visits:
            way += points[:2]
            sweeps += 4
        way += points[index : index + 1]
        sweeps += index < len(points)
    settled = len(points) + 2 * len(times.visits)
    expected_s = duration_of_moves(way) + settled * 0.5 + sweeps * 5 * 350e-6
    assert sum(times.durations_s) == pytest.approx(expected_s)
    begun = 0
    for index in times.visits:
        between_s = sum(alone.durations_s[begun:index])
        assert index == len(points) or interval_s <= between_s < interval_s + 10.0
        begun = index


def test_a_survey_that_is_shorter_than_the_interval_costs_nothing_more():
    points = survey_points(SMALL, TRAVEL)
    short_s = sum(planned_times(points, SMALL.sweep_settings, CONFIG, SurveySettings()).durations_s)
    times = planned_times(
        points, SMALL.sweep_settings, CONFIG, SurveySettings(reference_interval_s=short_s + 1.0)
    )
    assert (times.visits, len(times.durations_s)) == ((), len(points))
    assert sum(times.durations_s) == short_s
    long = survey_cost(PARAMETERS, CONFIG, SurveySettings(reference_interval_s=60.0))
    fast = survey_cost(
        PARAMETERS, replace(CONFIG, time_scale=10.0), SurveySettings(reference_interval_s=60.0)
    )
    assert fast.duration_s == pytest.approx(long.duration_s / 10.0)
