"""What a survey costs, time and size; lines that are added to a file."""

from dataclasses import replace

import pytest
from case_kit import each_case
from survey_examples import AXES, TRAVEL
from survey_examples import PARAMETERS as SMALL

from gpr20_survey.axes import AxisId
from gpr20_survey.files.durable_files import add_line, lines_backwards, object_of
from gpr20_survey.plan.robot_description import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveyParameters, SurveySettings
from gpr20_survey.plan.survey_points import (
    axis_move_duration_s,
    planned_times,
    survey_cost,
    survey_points,
)
from gpr20_survey.trace.sweep import AnalyzerSettings, SweepSettings, sweep_duration_s

CONFIG = RobotConfig(AXES, simulated=True)
PARAMETERS = SurveyParameters("127.0.0.1", 6.0e8, 6.0e9, 501, 50.0, 150.0, 5, 50.0, 150.0, 5)
TRACES = 50
POINT_S = 350e-6


def cost(parameters=PARAMETERS, config=CONFIG, **settings):
    return survey_cost(parameters, config, SurveySettings(**settings))


@each_case(
    "settings, other, each_s",
    [
        ({"settle_s": 0.5}, {"settle_s": 3.5}, 3.0),
        # The height is measured while vibrations settle.
        ({"settle_s": 0.5, "height_s": 0.4}, {"settle_s": 0.5, "height_s": 0.0}, 0.0),
        ({"settle_s": 0.5, "height_s": 0.4}, {"settle_s": 0.5, "height_s": 0.7}, 0.2),
    ],
)
def test_settling_and_height_cost_their_time_at_every_trace(settings, other, each_s):
    found_s = cost(**other).duration_s - cost(**settings).duration_s
    assert found_s == pytest.approx(TRACES * each_s)


@each_case(
    "analyzer, expected_s",
    [
        (AnalyzerSettings(), 501 * POINT_S),
        (AnalyzerSettings(20.0, 3), 3 * 501 * (POINT_S + 0.05 - 1e-4)),
        (AnalyzerSettings(averages=16), 16 * 501 * POINT_S),
    ],
)
def test_a_sweep_takes_longer_with_a_narrow_if_bandwidth_and_with_averages(analyzer, expected_s):
    duration_s = sweep_duration_s(SweepSettings(6.0e8, 6.0e9, 501, analyzer))
    assert duration_s == pytest.approx(expected_s)
    slow = replace(PARAMETERS, if_bandwidth_hz=analyzer.if_bandwidth_hz, averages=analyzer.averages)
    longer_s, usual_s = (
        cost(one, reference_interval_s=0.0).duration_s for one in (slow, PARAMETERS)
    )
    assert longer_s - usual_s == pytest.approx(TRACES * (expected_s - 501 * POINT_S), abs=1e-6)


def duration_of_moves(path):
    """Return how long moves through points take, each axis at its own duration [s]."""
    return sum(
        max(
            axis_move_duration_s(AXES[axis_id], getattr(after, name) - getattr(before, name))
            for axis_id, name in zip(AxisId, ("x_mm", "y_mm", "z_deg"))
        )
        for before, after in zip(path, path[1:])
    )


@pytest.mark.parametrize("interval_s", [15.0, 70.0, 1e6])
def test_the_visits_of_the_first_stop_are_part_of_the_planned_time(interval_s):
    points = survey_points(SMALL, TRAVEL)
    alone, times = (
        planned_times(points, SMALL.sweep_settings, CONFIG, SurveySettings(reference_interval_s=s))
        for s in (0.0, interval_s)
    )
    if interval_s > sum(alone.durations_s):
        assert (times.visits, times.durations_s) == ((), alone.durations_s)
        return
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
    expected_s = duration_of_moves(way) + settled * 0.5 + sweeps * 5 * POINT_S
    assert sum(times.durations_s) == pytest.approx(expected_s)
    for begun, index in zip((0, *times.visits), times.visits[:-1]):
        assert interval_s <= sum(alone.durations_s[begun:index]) < interval_s + 10.0


def test_a_line_that_a_crash_has_cut_damages_no_other(tmp_path):
    path = tmp_path / "checks" / "history.jsonl"
    assert not list(lines_backwards(path))
    add_line(path, {"a": 1})
    path.write_bytes(path.read_bytes() + b'{"b": ')
    add_line(path, {"c": "\u00f1\n"})
    with pytest.raises(ValueError):
        add_line(path, {"d": float("nan")})
    assert [*map(object_of, lines_backwards(path))] == [{"c": "\u00f1\n"}, {}, {"a": 1}]
