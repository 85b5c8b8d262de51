"""Echoes stand at their delay with their level, depths at their delay, noise at its level."""

import numpy as np
import pytest
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st

from gpr20_survey.radar.depth import delay_of_depth, depth_of_delay_m, one_way_path_m
from gpr20_survey.radar.frequency_to_delay import FrequencyToDelay, Window, delay_kernel
from gpr20_survey.radar.noise import LateDelays, late_delays_s, noise_of_traces


def echo(delay_s, level, frequency_hz):
    return level * np.exp(-2j * np.pi * frequency_hz * delay_s)


@settings(max_examples=60)
@given(st.floats(0.5e-9, 14e-9), st.floats(0.01, 2.0), st.integers(11, 4000))
def test_an_echo_stands_at_its_delay_with_its_level(delay_s, level, points):
    frequency_hz = np.linspace(0.6e9, 6.0e9, points)
    transform = FrequencyToDelay.resolved(frequency_hz, 1000)
    delay_s = min(delay_s, 0.8 * transform.delays_s[-1])
    found = np.abs(transform.transform(echo(delay_s, level, frequency_hz)))
    assert abs(transform.delays_s[np.argmax(found)] - delay_s) <= transform.step_s / 2 + 1e-15
    assert 0.93 * level < found.max() <= 1.001 * level


def test_uneven_frequencies_keep_the_echo_in_its_place():
    uneven_hz = np.sort(np.random.default_rng(1).uniform(0.6e9, 6.0e9, 801))
    transform = FrequencyToDelay.resolved(uneven_hz, 1000)
    found = np.abs(transform.transform(echo(4e-9, 1.0, uneven_hz)))
    assert abs(transform.delays_s[np.argmax(found)] - 4e-9) < transform.step_s


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
    late = 3.0 * (rng.standard_normal(4000) + 1j * rng.standard_normal(4000)) / np.sqrt(2.0)
    assert noise_of_traces(late) == pytest.approx(3.0, rel=0.05)
    late[:400] += 1000.0
    assert noise_of_traces(late) == pytest.approx(3.0, rel=0.1)
