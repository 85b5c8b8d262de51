"""Echoes, depths, refraction and soils are as physics says."""

import math

import numpy as np
import pytest
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_survey import radar
from gpr20_survey.folder.log_record import (
    ENTERED,
    LOG,
    OF_PLAN,
    PLANNED_PERMITTIVITY,
    Kind,
    LogRecord,
    description_of,
    soil_of_survey,
    soil_values,
)
from gpr20_survey.radar import FrequencyToDelay, Soils, Window


def echo(delay_s, level, frequency_hz):
    return level * np.exp(-2j * np.pi * frequency_hz * delay_s)


@settings(max_examples=draws(15))
@given(st.floats(0.5e-9, 14e-9), st.floats(0.01, 2.0), st.integers(11, 4000))
def test_an_echo_stands_at_its_delay_with_its_level(delay_s, level, points):
    frequency_hz = np.linspace(0.6e9, 6.0e9, points)
    transform = FrequencyToDelay.resolved(frequency_hz, 1000)
    delay_s = min(delay_s, 0.8 * transform.delays_s[-1])
    found = np.abs(transform.transform(echo(delay_s, level, frequency_hz)))
    assert abs(transform.delays_s[np.argmax(found)] - delay_s) <= transform.step_s / 2 + 1e-15
    assert 0.93 * level < found.max() <= 1.001 * level


def test_depth_counts_from_the_surface_in_ground_of_the_permittivity():
    assert radar.delay_of_depth(0.0, 0.15, 9.0) == pytest.approx(1.0007e-9, rel=1e-3)
    assert radar.delay_of_depth(0.1, 0.0, 9.0) == pytest.approx(
        3 * radar.delay_of_depth(0.1, 0.0, 1.0)
    )
    # Above the surface there is air.
    assert radar.delay_of_depth(-0.05, 0.15, 9.0) == pytest.approx(
        radar.delay_of_depth(0.0, 0.10, 9.0)
    )
    assert radar.depth_of_delay_m(radar.delay_of_depth(0.1, 0.15, 9.0), 0.15, 9.0) == pytest.approx(
        0.1
    )
    assert radar.depth_of_delay_m(radar.delay_of_depth(-0.1, 0.15, 9.0), 0.15, 9.0) == 0.0
    assert radar.one_way_path_m(1e-9, 9.0) == pytest.approx(0.05, rel=1e-3)


@each_case("window", Window)
@each_case("count", [2, 3, 101])
def test_a_window_is_symmetric_and_leaves_the_level_of_an_echo(window, count):
    shares = window.shares(count)
    assert shares == pytest.approx(shares[::-1])
    assert (shares > 0.0).all()
    frequency_hz = np.linspace(1e9, 2e9, count)
    peak = echo(3e-9, 0.2, frequency_hz) @ radar.delay_kernel(
        frequency_hz, np.array([3e-9]), window
    )
    assert peak == pytest.approx(0.2)


HEIGHTS_M = st.floats(0.02, 0.5)
DEPTHS_M = st.floats(0.02, 0.4)
PERMITTIVITIES = st.floats(1.5, 40.0)


@settings(max_examples=draws(15))
@given(st.floats(0.0, 0.5), DEPTHS_M, HEIGHTS_M, PERMITTIVITIES)
def test_the_wave_takes_the_fastest_path(offset_m, depth_m, height_m, permittivity):
    crossings_m = np.linspace(0.0, offset_m, 4001)
    index = math.sqrt(permittivity)
    paths_m = np.hypot(height_m, crossings_m) + index * np.hypot(depth_m, offset_m - crossings_m)
    fastest_s = paths_m.min() / radar.SPEED_OF_LIGHT_M_S
    found_s = radar.one_way_delay_s(height_m, depth_m, offset_m, permittivity)
    assert found_s == pytest.approx(fastest_s, rel=1e-6)


@each_case("soil", Soils)
def test_a_soil_is_known_by_its_permittivity(soil):
    assert radar.MIN_PERMITTIVITY < soil.value.permittivity < radar.MAX_PERMITTIVITY
    assert radar.soil_of(soil.value.permittivity) is soil


def test_a_survey_that_is_resumed_keeps_its_soil_until_somebody_decides_again():
    records, said = [], []
    for kind, values in (
        (Kind.PLAN, {PLANNED_PERMITTIVITY: 4.0, "started": "2026"}),
        (Kind.RESUME, {}),
        (Kind.DECISION, {"accepted": "other zeros"}),
        (Kind.DECISION, soil_values(9.5, 0)),
        (Kind.RESUME, {}),
        (Kind.DECISION, soil_values(7.0, 0)),
        (Kind.END, {"outcome": "finished"}),
        (Kind.DECISION, soil_values(None, 0)),
    ):
        records.append(LogRecord.after(records[-1] if records else None, kind, values, "2026"))
        log = [one.as_json() for one in records]
        said.append(soil_of_survey({**description_of(records), LOG: log}))
    plan, last = (4.0, OF_PLAN), (7.0, ENTERED)
    assert said == [plan, plan, plan, *[(9.5, ENTERED)] * 2, last, last, None]
