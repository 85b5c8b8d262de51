"""What a survey costs, time and size, and how a daily check judges the robot before one."""

from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case
from survey_examples import AXES, TRAVEL
from survey_examples import PARAMETERS as SMALL

from gpr20_common.mid.codec import plain
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.files.json_lines import add_line, lines_backwards, object_of
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import (
    RemainingTime,
    axis_move_duration_s,
    planned_times,
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


@each_case("done, spent_s, left_s", [(0, 5.0, 60.0), (1, 15.0, 75.0), (3, 90.0, 0.0)])
def test_the_remaining_time_is_the_plan_at_the_pace_so_far(done, spent_s, left_s):
    assert RemainingTime([10.0, 20.0, 30.0]).remaining_s(done, spent_s) == pytest.approx(left_s)


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


@each_case("level, delay_ns", [(0.001, 1.23456), (0.5, 8.1)])
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
        ({"noise": 1e-4}, "noise: differs by +"),
        # Less noise is no fault.
        ({"noise": 1e-7}, "agrees"),
        ({"plate": (0.0, 3.0)}, "No echo of the metal plate"),
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
    assert figures_from(plain(figures())) == figures()
    for odd in (
        None,
        {"sky": {}},
        {"empty": 7},
        {"empty": {"level_db": "x"}},
        {"empty": {"a": [1]}},
    ):
        with pytest.raises(ValueError):
            figures_from(odd)


def test_a_line_that_a_crash_has_cut_damages_no_other(tmp_path):
    path = tmp_path / "checks" / "history.jsonl"
    assert not list(lines_backwards(path))
    add_line(path, {"a": 1})
    path.write_bytes(path.read_bytes() + b'{"b": ')
    add_line(path, {"c": "\u00f1\n"})
    with pytest.raises(ValueError):
        add_line(path, {"d": float("nan")})
    assert [*map(object_of, lines_backwards(path))] == [{"c": "\u00f1\n"}, {}, {"a": 1}]
