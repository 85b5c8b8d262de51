"""Drift between two sweeps of one place: known changes are recovered."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gpr20_survey.radar.drift import drift_between, noise_db

HZ = np.linspace(600.0e6, 6.0e9, 101)


def echoes(seed):
    """Return a sweep with a coupling and an echo, which has deep nulls."""
    random = np.random.default_rng(seed)
    levels, delays_s = random.uniform(0.01, 1.0, 2), random.uniform(0.5e-9, 8e-9, 2)
    return sum(
        level * np.exp(-2j * np.pi * HZ * delay_s) for level, delay_s in zip(levels, delays_s)
    )


@settings(max_examples=200, deadline=None)
@given(
    st.integers(0, 2**31),
    st.floats(-20.0, 20.0),
    st.floats(-4e-9, 4e-9),
    st.floats(-120.0, -60.0),
)
def test_a_known_gain_and_delay_are_recovered_below_noise(seed, gain_db, delay_s, noise):
    before = echoes(seed)
    level = math.sqrt(np.mean(np.abs(before) ** 2)) * 10.0 ** (noise / 20.0)
    random = np.random.default_rng(seed + 1)
    hiss = level * (random.standard_normal(101) + 1j * random.standard_normal(101))
    changed = 10.0 ** (gain_db / 20.0) * (before + hiss) * np.exp(-2j * np.pi * HZ * delay_s)
    found = drift_between(HZ, before, changed)
    assert found.gain_db == pytest.approx(gain_db, abs=0.02)
    assert found.delay_s == pytest.approx(delay_s, abs=1e-12)
    assert found.amplitude_rms_db == pytest.approx(abs(gain_db), abs=0.05)


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 2**31), st.floats(-40.0, 40.0), st.floats(-179.0, 179.0))
def test_a_known_gain_and_phase_are_recovered_at_every_frequency(seed, gain_db, phase_deg):
    before = echoes(seed)
    turned = before * 10.0 ** (gain_db / 20.0) * np.exp(1j * math.radians(phase_deg))
    found = drift_between(HZ, before, turned)
    assert found.amplitude_db == pytest.approx(np.full(101, gain_db), abs=1e-6)
    assert found.phase_deg == pytest.approx(np.full(101, phase_deg), abs=1e-6)
    assert found.phase_rms_deg == pytest.approx(abs(phase_deg), abs=1e-6)
    assert found.delay_s == pytest.approx(0.0, abs=1e-15)


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


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**31), st.floats(-100.0, -20.0))
def test_the_noise_floor_is_that_of_one_sweep(seed, level_db):
    random = np.random.default_rng(seed)
    level = 10.0 ** (level_db / 20.0) / math.sqrt(2.0)
    first, second = (
        1.0 + level * (random.standard_normal(4000) + 1j * random.standard_normal(4000))
        for _ in range(2)
    )
    assert noise_db(first, second) == pytest.approx(level_db, abs=0.5)
    assert noise_db(first, first) == -math.inf
