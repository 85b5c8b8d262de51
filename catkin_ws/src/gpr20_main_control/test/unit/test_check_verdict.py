"""Drift, noise and the verdict of a daily check are what the sweeps say."""

import math

import numpy as np
import pytest
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_common.mid.codec import plain
from gpr20_main_control.mid.check_verdict import check_figures, figures_from, judge
from gpr20_main_control.mid.sweep_difference import drift_between, noise_db
from gpr20_survey.results.daily_check import Part
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

HZ = np.linspace(600.0e6, 6.0e9, 501)
NOISE = 1e-5


def echo(level, delay_s):
    return level * np.exp(-2j * np.pi * HZ * delay_s)


COUPLING = echo(0.05, 0.8e-9)


def hiss(random, level, count):
    parts = random.standard_normal((2, count)) * level / math.sqrt(2.0)
    return parts[0] + 1j * parts[1]


def echoes(seed):
    # A coupling and an echo: they have deep nulls.
    random = np.random.default_rng(seed)
    return sum(map(echo, random.uniform(0.01, 1.0, 2), random.uniform(0.5e-9, 8e-9, 2)))


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
    noisy = before + hiss(np.random.default_rng(seed + 1), level, 501)
    changed = noisy * echo(10.0 ** (gain_db / 20.0), delay_s)
    found = drift_between(HZ, before, changed)
    assert found.gain_db == pytest.approx(gain_db, abs=0.02)
    assert found.delay_s == pytest.approx(delay_s, abs=1e-12)
    assert found.amplitude_rms_db == pytest.approx(abs(gain_db), abs=0.05)


def test_the_drift_of_a_single_frequency_shows_there():
    after = np.ones(501, complex)
    after[7] = 2.0j
    found = drift_between(HZ, np.ones(501, complex), after)
    assert (found.amplitude_db[7], found.phase_deg[7]) == pytest.approx((6.0206, 90.0), abs=1e-4)
    assert not np.delete(found.amplitude_db, 7).any()


def test_a_signal_that_is_gone_is_an_infinite_drift():
    nothing, signal = np.zeros(501, complex), np.ones(501, complex)
    assert drift_between(HZ, signal, nothing).amplitude_rms_db == math.inf
    appeared = drift_between(HZ, nothing, signal)
    assert (appeared.amplitude_rms_db, appeared.phase_rms_deg) == (math.inf, math.inf)


@given(st.integers(0, 2**31), st.floats(-100.0, -20.0))
def test_the_noise_floor_is_that_of_one_sweep(seed, level_db):
    random = np.random.default_rng(seed)
    first, second = (1.0 + hiss(random, 10.0 ** (level_db / 20.0), 4000) for _ in range(2))
    assert noise_db(first, second) == pytest.approx(level_db, abs=0.5)
    assert noise_db(first, first) == -math.inf


def pair(s21, random, noise=NOISE):
    sweeps = []
    for _ in range(2):
        values = s21 + hiss(random, noise * math.sqrt(2.0), 501)
        parts = (HZ, values.real, values.imag)
        sweeps.append(Sweep(*parts, 2 * 10**15, 2 * 10**15, (), AnalyzerSettings()))
    return tuple(sweeps)


def figures(seed=1, gain=1.0, plate=(0.02, 3e-9), reflector=(0.005, 4.5e-9), noise=NOISE):
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
    found = figures(plate=(level, delay_ns * 1e-9))
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
        ({"plate": (0.02, 3.25e-9)}, "metal plate, delay of the echo: differs by +0.25 ns"),
        ({"noise": 1e-4}, "noise: differs by +"),
        # Less noise is no fault.
        ({"noise": 1e-7}, "agrees"),
        ({"plate": (0.0, 3e-9)}, "No echo of the metal plate"),
    ],
)
def test_the_verdict_names_what_differs_most_and_what_to_check(changes, words):
    verdict = judge(figures(seed=99, **changes), HISTORY)
    assert verdict.good is ("agree" in words)
    assert words in str(verdict.message)
    assert verdict.good or "check" in str(verdict.message)


def test_the_first_check_a_silent_analyzer_and_a_single_odd_check_are_judged_as_good():
    first = judge(figures(), [])
    assert first.good
    silent = figures(noise=0.0)
    assert silent[Part.EMPTY]["noise_db"] is None
    assert judge(silent, [silent, silent]).good
    assert judge(figures(4), [*HISTORY[:3], figures(3, plate=(0.05, 5e-9))]).good


def test_stored_figures_are_read_as_they_were():
    assert figures_from(plain(figures())) == figures()
    for odd in (None, {"sky": {}}, *({"empty": one} for one in (7, {"a": "x"}, {"a": [1]}))):
        with pytest.raises(ValueError):
            figures_from(odd)
