"""Echoes, depths, hyperbolas, noise, drift and soils are as physics says."""

import math

import numpy as np
import pytest
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_survey.folder.log_content import LOG, description_of
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.soil_note import (
    ENTERED,
    KIND,
    OF_PLAN,
    PLANNED,
    soil_of_survey,
    soil_values,
)
from gpr20_survey.radar.depth import (
    SPEED_OF_LIGHT_M_S,
    delay_of_depth,
    depth_of_delay_m,
    one_way_path_m,
)
from gpr20_survey.radar.drift import drift_between, noise_db
from gpr20_survey.radar.frequency_to_delay import FrequencyToDelay, Window, delay_kernel
from gpr20_survey.radar.hyperbola import Hyperbola
from gpr20_survey.radar.noise import LateDelays, late_delays_s, noise_of_traces
from gpr20_survey.radar.refraction import one_way_delay_s
from gpr20_survey.radar.soils import MAX_PERMITTIVITY, MIN_PERMITTIVITY, Soils, soil_of


def echo(delay_s, level, frequency_hz):
    return level * np.exp(-2j * np.pi * frequency_hz * delay_s)


def hiss(random, level, count):
    parts = random.standard_normal((2, count)) * level / math.sqrt(2.0)
    return parts[0] + 1j * parts[1]


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
    assert delay_of_depth(0.0, 0.15, 9.0) == pytest.approx(1.0007e-9, rel=1e-3)
    assert delay_of_depth(0.1, 0.0, 9.0) == pytest.approx(3 * delay_of_depth(0.1, 0.0, 1.0))
    # Above the surface there is air.
    assert delay_of_depth(-0.05, 0.15, 9.0) == pytest.approx(delay_of_depth(0.0, 0.10, 9.0))
    assert depth_of_delay_m(delay_of_depth(0.1, 0.15, 9.0), 0.15, 9.0) == pytest.approx(0.1)
    assert depth_of_delay_m(delay_of_depth(-0.1, 0.15, 9.0), 0.15, 9.0) == 0.0
    assert one_way_path_m(1e-9, 9.0) == pytest.approx(0.05, rel=1e-3)


@each_case("window", Window)
@each_case("count", [2, 3, 101])
def test_a_window_is_symmetric_and_leaves_the_level_of_an_echo(window, count):
    shares = window.shares(count)
    assert shares == pytest.approx(shares[::-1])
    assert (shares > 0.0).all()
    frequency_hz = np.linspace(1e9, 2e9, count)
    peak = echo(3e-9, 0.2, frequency_hz) @ delay_kernel(frequency_hz, np.array([3e-9]), window)
    assert peak == pytest.approx(0.2)


def test_late_delays_hold_noise_and_not_the_echoes_of_the_ground():
    frequency_hz = np.linspace(0.6e9, 6.0e9, 501)
    late = LateDelays(frequency_hz)
    assert np.abs(late.samples(echo(8e-9, 1.0, frequency_hz))).max() < 1e-3
    delay_s = late_delays_s(frequency_hz)[10]
    assert np.abs(late.samples(echo(delay_s, 1.0, frequency_hz))).max() == pytest.approx(1.0)


def test_the_noise_of_a_trace_is_its_root_mean_square_also_beside_late_echoes():
    rng = np.random.default_rng(6)
    late = hiss(rng, 3.0, 4000)
    assert noise_of_traces(late) == pytest.approx(3.0, rel=0.05)
    late[:400] += 1000.0
    assert noise_of_traces(late) == pytest.approx(3.0, rel=0.1)


HEIGHTS_M = st.floats(0.02, 0.5)
DEPTHS_M = st.floats(0.02, 0.4)
PERMITTIVITIES = st.floats(1.5, 40.0)


@settings(max_examples=draws(15))
@given(st.floats(0.0, 0.5), DEPTHS_M, HEIGHTS_M, PERMITTIVITIES)
def test_the_wave_takes_the_fastest_path(offset_m, depth_m, height_m, permittivity):
    crossings_m = np.linspace(0.0, offset_m, 4001)
    index = math.sqrt(permittivity)
    paths_m = np.hypot(height_m, crossings_m) + index * np.hypot(depth_m, offset_m - crossings_m)
    fastest_s = paths_m.min() / SPEED_OF_LIGHT_M_S
    found_s = one_way_delay_s(height_m, depth_m, offset_m, permittivity)
    assert found_s == pytest.approx(fastest_s, rel=1e-6)


@settings(max_examples=draws(15))
@given(DEPTHS_M, HEIGHTS_M, PERMITTIVITIES, st.floats(40.0, 400.0), st.sampled_from([-1, 1]))
def test_a_point_of_the_flank_gives_the_permittivity(depth_m, height_m, truth, offset_mm, side):
    apex_s = float(delay_of_depth(depth_m, height_m, truth))
    target = Hyperbola(300.0, apex_s, height_m, truth)
    assert target.depth_m == pytest.approx(depth_m, rel=1e-6)
    place_mm = 300.0 + side * offset_mm
    delay_s = float(target.delays_s(np.array([place_mm]))[0])
    start = Hyperbola(300.0, apex_s, height_m, 4.0)
    assert start.through(place_mm, delay_s).permittivity == pytest.approx(truth, rel=1e-2)


@each_case("delay_s", [0.0, 1.0])
def test_a_point_that_no_ground_explains_ends_at_the_limits(delay_s):
    fitted = Hyperbola(100.0, 2e-9, 0.1, 6.0).through(200.0, delay_s)
    assert fitted.permittivity == pytest.approx(1.0 if delay_s == 0.0 else 81.0, rel=1e-6)


HZ = np.linspace(600.0e6, 6.0e9, 101)


def echoes(seed):
    """Return a sweep with a coupling and an echo, which has deep nulls."""
    random = np.random.default_rng(seed)
    levels, delays_s = random.uniform(0.01, 1.0, 2), random.uniform(0.5e-9, 8e-9, 2)
    return sum(echo(delay_s, level, HZ) for level, delay_s in zip(levels, delays_s))


@settings(max_examples=draws(50))
@given(
    st.integers(0, 2**31),
    st.floats(-20.0, 20.0),
    st.floats(-4e-9, 4e-9),
    st.floats(-120.0, -60.0),
)
def test_a_known_gain_and_delay_are_recovered_below_noise(seed, gain_db, delay_s, noise):
    before = echoes(seed)
    level = math.sqrt(2.0 * np.mean(np.abs(before) ** 2)) * 10.0 ** (noise / 20.0)
    noisy = before + hiss(np.random.default_rng(seed + 1), level, 101)
    changed = noisy * echo(delay_s, 10.0 ** (gain_db / 20.0), HZ)
    found = drift_between(HZ, before, changed)
    assert found.gain_db == pytest.approx(gain_db, abs=0.02)
    assert found.delay_s == pytest.approx(delay_s, abs=1e-12)
    assert found.amplitude_rms_db == pytest.approx(abs(gain_db), abs=0.05)


def test_the_drift_of_a_single_frequency_shows_there():
    after = np.ones(101, complex)
    after[7] = 2.0j
    found = drift_between(HZ, np.ones(101, complex), after)
    assert (found.amplitude_db[7], found.phase_deg[7]) == pytest.approx((6.0206, 90.0), abs=1e-4)
    assert not np.delete(found.amplitude_db, 7).any()


def test_a_signal_that_is_gone_is_an_infinite_drift():
    nothing, signal = np.zeros(101, complex), np.ones(101, complex)
    assert drift_between(HZ, signal, nothing).amplitude_rms_db == math.inf
    assert drift_between(HZ, nothing, signal).amplitude_rms_db == math.inf
    assert drift_between(HZ, nothing, signal).phase_rms_deg == math.inf


@given(st.integers(0, 2**31), st.floats(-100.0, -20.0))
def test_the_noise_floor_is_that_of_one_sweep(seed, level_db):
    random = np.random.default_rng(seed)
    first, second = (1.0 + hiss(random, 10.0 ** (level_db / 20.0), 4000) for _ in range(2))
    assert noise_db(first, second) == pytest.approx(level_db, abs=0.5)
    assert noise_db(first, first) == -math.inf


@each_case("soil", Soils)
def test_a_soil_is_known_by_its_permittivity(soil):
    assert MIN_PERMITTIVITY < soil.value.permittivity < MAX_PERMITTIVITY
    assert soil_of(soil.value.permittivity) is soil


def test_a_survey_that_is_resumed_keeps_its_soil_until_somebody_decides_again():
    records, said = [], []
    for kind, values in (
        (Kind.PLAN, {PLANNED: 4.0, "started": "2026"}),
        (Kind.RESUME, {}),
        (Kind.DECISION, {"accepted": "other zeros"}),
        (KIND, soil_values(9.5, 0)),
        (Kind.RESUME, {}),
        (KIND, soil_values(7.0, 0)),
        (Kind.END, {"outcome": "finished"}),
        (KIND, soil_values(None, 0)),
    ):
        records.append(LogRecord.after(records[-1] if records else None, kind, values, "2026"))
        log = [one.as_json() for one in records]
        said.append(soil_of_survey({**description_of(records), LOG: log}))
    plan, last = (4.0, OF_PLAN), (7.0, ENTERED)
    assert said == [plan, plan, plan, *[(9.5, ENTERED)] * 2, last, last, None]
