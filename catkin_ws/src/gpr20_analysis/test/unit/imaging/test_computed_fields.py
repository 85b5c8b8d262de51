"""The fields that the computed lines of the benchmark are made of, against closed forms."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.constants import epsilon_0, mu_0, speed_of_light
from scipy.special import hankel2

WORLDS = Path(__file__).resolve().parents[6] / "benchmarks/worlds"
CELL_M, ROWS, COLUMNS = 0.0015, 220, 300
SOURCE, RECEIVER, SURFACE = (100, 130), (100, 170), 160
FREQUENCY_HZ = np.linspace(1e9, 5e9, 5)
PERMITTIVITY = 4.0


@pytest.fixture(scope="module")
def field():
    sys.path.insert(0, str(WORLDS))
    yield importlib.import_module("line_field")
    sys.path.remove(str(WORLDS))


def received(field, ground):
    """Return the transfer function of line sources 60 mm apart, per unit of the source's current.

    The scheme adds COURANT times the pulse to the field in each step.
    """
    step_s = field.step_s(CELL_M)
    sent = field.pulse(2.6e9, step_s, 900)
    materials = field.Materials(np.array([1.0, PERMITTIVITY]), np.zeros(2))
    windows = field.Windows(ground, np.zeros(1, int), COLUMNS, SOURCE, RECEIVER)
    echoes = field.received(windows, materials, CELL_M, sent, False)
    current = epsilon_0 * field.COURANT / step_s * CELL_M**2
    return field.transfer(echoes, sent, step_s, FREQUENCY_HZ)[0] / current


@pytest.fixture(scope="module")
def free_space(field):
    return received(field, np.zeros((ROWS, COLUMNS), np.uint8))


def test_in_free_space_it_is_hankels_function(free_space):
    away_m = (RECEIVER[1] - SOURCE[1]) * CELL_M
    wave = 2.0 * np.pi * FREQUENCY_HZ / speed_of_light
    expected = -np.pi * FREQUENCY_HZ * mu_0 / 2.0 * hankel2(0, wave * away_m)
    assert np.abs(free_space / expected - 1.0).max() < 0.01


def test_over_soil_the_echo_of_the_surface_is_sommerfelds_integral(field, free_space):
    ground = np.zeros((ROWS, COLUMNS), np.uint8)
    ground[SURFACE:] = 1
    echo = received(field, ground) - free_space
    height_m = (SURFACE - 0.5 - SOURCE[0]) * CELL_M
    away_m = (RECEIVER[1] - SOURCE[1]) * CELL_M
    for frequency_hz, found in zip(FREQUENCY_HZ[:4], echo):
        # A little loss keeps the path of the integral off the branch points.
        wave = 2.0 * np.pi * frequency_hz / speed_of_light * (1.0 - 1e-4j)
        across = np.linspace(-6.0, 6.0, 1_000_001) * abs(wave)
        above, below = (_downward(wave, across, one) for one in (1.0, PERMITTIVITY))
        reflected = (above - below) / (above + below)
        values = reflected * np.exp(-1j * (above * 2.0 * height_m + across * away_m)) / above
        integral = np.sum(values) * (across[1] - across[0])
        expected = -frequency_hz * mu_0 / 2.0 * integral
        assert abs(found / expected - 1.0) < 0.03, frequency_hz


def _downward(wave, across, permittivity):
    down = np.sqrt(permittivity * wave**2 - across**2 + 0j)
    return np.where(down.imag > 0.0, -down, down)
