"""What a survey costs, time and size, and how a daily check judges the robot before one."""

from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from survey_examples import AXES, TRAVEL
from survey_examples import PARAMETERS as SMALL

from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.files.json_lines import add_line, read_lines
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
from gpr20_survey.results.daily_check import (
    Part,
    check_figures,
    figures_from,
    judge,
    recorded_figures,
)
from gpr20_survey.trace.ms2026c import sweep_duration_s
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings

CONFIG = RobotConfig(AXES, simulated=True)
PARAMETERS = SurveyParameters("127.0.0.1", 6.0e8, 6.0e9, 501, 50.0, 150.0, 5, 50.0, 150.0, 5)
TRACES = 50
POINT_S = 350e-6


def cost(parameters=PARAMETERS, config=CONFIG, **settings):
    return survey_cost(parameters, config, SurveySettings(**settings))


def test_a_robot_that_runs_faster_needs_less_time_and_fewer_messages():
    slow, fast = cost(), cost(config=replace(CONFIG, time_scale=10.0))
    assert fast.duration_s == pytest.approx(slow.duration_s / 10.0)
    assert TRACES * 501 * 3 * 24 < fast.size_bytes < slow.size_bytes


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
        (AnalyzerSettings(100_000.0, 1), 501 * POINT_S),
        (AnalyzerSettings(10_000.0, 1), 501 * POINT_S),
        (AnalyzerSettings(20.0, 1), 501 * (POINT_S + 0.05 - 1e-4)),
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


def test_a_bandwidth_that_is_left_to_the_instrument_may_be_assumed_to_be_narrow():
    left, stated = (SweepSettings(6.0e8, 6.0e9, 501, AnalyzerSettings(hz)) for hz in (0.0, 10.0))
    assert sweep_duration_s(left, 1e-3, 10.0) == sweep_duration_s(stated, 1e-3)


@given(st.sampled_from(list(AxisId)), st.floats(min_value=-90.0, max_value=90.0))
def test_what_is_kept_of_a_distance_is_what_is_computed(axis_id, distance):
    kept = move_durations(CONFIG.axes)
    expected_s = axis_move_duration_s(CONFIG.axes[axis_id], distance)
    assert kept(axis_id, distance) == kept(axis_id, distance) == expected_s


def test_a_point_takes_the_longest_of_its_moves_and_the_measurement():
    points = survey_points(SMALL, TRAVEL)
    times = MeasuringTimes(settle_s=0.5, height_s=0.4, sweep=SweepSettings(6.0e8, 6.0e9, 4000))
    durations = point_durations_s(points, lambda axis_id, distance: abs(distance), times)
    assert durations[:2] == pytest.approx([10.0 + 0.5 + 1.4, 90.0 + 0.5 + 1.4])
    assert len(durations) == len(points)


@each_case("done, spent_s, left_s", [(0, 5.0, 60.0), (1, 15.0, 75.0), (3, 90.0, 0.0)])
def test_the_remaining_time_is_the_plan_at_the_pace_so_far(done, spent_s, left_s):
    assert RemainingTime([10.0, 20.0, 30.0]).remaining_s(done, spent_s) == pytest.approx(left_s)


def test_the_size_grows_with_traces_points_and_time():
    base = needed_bytes(18, 501, 100.0)
    for more in ((36, 501, 100.0), (18, 1001, 100.0), (18, 501, 1000.0)):
        assert needed_bytes(*more) > base


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
    begun = 0
    for index in times.visits:
        between_s = sum(alone.durations_s[begun:index])
        assert index == len(points) or interval_s <= between_s < interval_s + 10.0
        begun = index


HZ = np.linspace(600.0e6, 6.0e9, 501)
COUPLING = 0.05 * np.exp(-2j * np.pi * HZ * 0.8e-9)
NOISE = 1e-5
SWEPT_US = 1_800_000_000_000_000


def echo(level, delay_ns):
    return level * np.exp(-2j * np.pi * HZ * delay_ns * 1e-9)


def pair(s21, random, noise=NOISE):
    """Return two sweeps in a row, with noise."""
    sweeps = []
    for _ in range(2):
        values = s21 + noise * (random.standard_normal(501) + 1j * random.standard_normal(501))
        parts = (HZ, values.real, values.imag)
        sweeps.append(Sweep(*parts, SWEPT_US, SWEPT_US, (), AnalyzerSettings()))
    return tuple(sweeps)


def figures(seed=1, gain=1.0, plate=(0.02, 3.0), reflector=(0.005, 4.5), noise=NOISE):
    random = np.random.default_rng(seed)
    return check_figures(
        {
            Part.EMPTY: pair(gain * COUPLING, random, noise),
            Part.PLATE: pair(gain * (COUPLING + echo(*plate)), random, noise),
            Part.REFLECTOR: pair(gain * (COUPLING + echo(*reflector)), random, noise),
        }
    )


@each_case("level, delay_ns", [(0.02, 3.0), (0.001, 1.23456), (0.5, 8.1), (0.0003, 14.0)])
def test_the_figures_of_a_check_are_those_of_its_sweeps(level, delay_ns):
    found = figures(plate=(level, delay_ns))
    assert found[Part.PLATE]["delay_ns"] == pytest.approx(delay_ns, abs=0.002)
    assert found[Part.PLATE]["echo_db"] == pytest.approx(20.0 * np.log10(level), abs=0.05)
    empty = found[Part.EMPTY]
    assert empty["level_db"] == pytest.approx(20.0 * np.log10(0.05), abs=0.01)
    noise_db = 20.0 * np.log10(NOISE * np.sqrt(2.0) / 0.05)
    assert empty["noise_db"] == pytest.approx(noise_db, abs=1.0)
    assert "echo_db" not in empty


HISTORY = [figures(seed) for seed in range(2, 9)]


@each_case(
    "changes, words",
    [
        ({}, "agrees with the median of the checks before (7)"),
        ({"gain": 0.8}, "-1.94 dB"),
        ({"plate": (0.02, 3.25)}, "metal plate, delay of the echo: differs by +0.25 ns"),
        ({"plate": (0.01, 3.0)}, "metal plate, level of the echo: differs by -6.02 dB"),
        ({"reflector": (0.005, 4.2)}, "known reflector, delay of the echo: differs by -0.30 ns"),
        ({"noise": 1e-4}, "noise: differs by +"),
        # Less noise is no fault.
        ({"noise": 1e-7}, "agrees"),
        ({"plate": (0.0, 3.0)}, "No echo of the metal plate"),
        ({"reflector": (3e-6, 4.5)}, "No echo of the known reflector"),
    ],
)
def test_the_verdict_names_what_differs_most_and_what_to_check(changes, words):
    verdict = judge(figures(seed=99, **changes), HISTORY)
    assert verdict.good is ("agree" in words)
    assert words in str(verdict.message)
    assert verdict.good or "check" in str(verdict.message)


def test_the_first_check_a_silent_analyzer_and_a_single_odd_check_are_judged_as_good():
    first = judge(figures(), [])
    assert first.good and len(first.comparisons) == 10
    silent = figures(noise=0.0)
    assert silent[Part.EMPTY]["noise_db"] is None
    assert judge(silent, [silent, silent]).good
    odd = figures(seed=3, plate=(0.05, 5.0))
    assert judge(figures(seed=4), [*HISTORY[:3], odd]).good


def test_stored_figures_are_read_as_they_were():
    assert figures_from(recorded_figures(figures())) == figures()
    for odd in ({"sky": {}}, {"empty": 7}, {"empty": {"level_db": "x"}}, {"empty": {"a": [1]}}):
        with pytest.raises(ValueError):
            figures_from(odd)


def test_a_line_that_a_crash_has_cut_damages_no_other(tmp_path):
    path = tmp_path / "checks" / "history.jsonl"
    assert read_lines(path) == ([], 0)
    add_line(path, {"a": 1})
    path.write_bytes(path.read_bytes() + b'{"b": ')
    add_line(path, {"c": "\u00f1\n"})
    assert read_lines(path) == ([{"a": 1}, {"c": "\u00f1\n"}], 1)
    with pytest.raises(ValueError):
        add_line(path, {"d": float("nan")})
    assert read_lines(path)[1] == 1
