"""The fields that the Born scenes of the benchmark are made of, against closed forms and grids."""

from __future__ import annotations

import importlib
import json
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from recorded_worlds import BORN, truths
from scipy.constants import epsilon_0, mu_0, speed_of_light

WORLDS = Path(__file__).resolve().parents[6] / "benchmarks/worlds"
HEIGHT_M, APART_M = 0.06, 0.06


@pytest.fixture(scope="module")
def load():
    sys.path.insert(0, str(WORLDS))
    yield importlib.import_module
    sys.path.remove(str(WORLDS))


@pytest.fixture(scope="module")
def field(load):
    return load("born_field")


def dipole_in_air(frequency_hz, place_m):
    """Return the field of a dipole of 1 A m along X, near field and all, at a place (3)."""
    wave = 2.0 * np.pi * frequency_hz / speed_of_light
    away_m = float(np.linalg.norm(place_m))
    to = np.array(place_m) / away_m
    path = 1j * wave * away_m
    across, along = 1.0 + 1.0 / path + 1.0 / path**2, 1.0 + 3.0 / path + 3.0 / path**2
    spread = -1j * frequency_hz * mu_0 / 2.0 * np.exp(-path) / away_m
    return spread * (np.array([1.0, 0.0, 0.0]) * across - to * to[0] * along)


def at_azimuth(parts, azimuth):
    zeroth, first, second = parts
    double = 2.0 * azimuth
    return np.array(
        [zeroth + second * np.cos(double), second * np.sin(double), first * np.cos(azimuth)]
    )


@pytest.mark.parametrize("frequency_hz", [1e9, 5e9])
def test_into_ground_like_air_it_is_hertzs_dipole(field, frequency_hz):
    distance_m, depth_m = np.array([0.0, 0.01, 0.05, 0.2, 0.8]), np.array([0.03, 0.15])
    parts = field.transmitted(frequency_hz, 1.0 + 0.0j, HEIGHT_M, depth_m, distance_m)
    for azimuth in (0.0, 0.7, 1.9):
        turn = np.array([np.cos(azimuth), np.sin(azimuth)])
        for deep, down_m in enumerate(depth_m):
            for away, across_m in enumerate(distance_m):
                place_m = (*(across_m * turn), HEIGHT_M + down_m)
                expected = dipole_in_air(frequency_hz, place_m)
                error = np.abs(at_azimuth(parts[:, deep, away], azimuth) - expected).max()
                assert error < 1e-6 * np.abs(expected).max()


def test_far_below_it_is_a_refracted_ray(field):
    """By Fresnel's coefficients, and the spreading of a narrow bundle of rays."""
    frequency_hz, index, depth_m = 3e9, 2.0, 4.0
    wave = 2.0 * np.pi * frequency_hz / speed_of_light
    for angle in (0.0, 0.6):
        below = np.arcsin(np.sin(angle) / index)
        cosine, refracted = np.cos(angle), np.cos(below)
        distance_m = HEIGHT_M * np.tan(angle) + depth_m * np.tan(below)
        parts = field.transmitted(
            frequency_hz, index**2 + 0j, HEIGHT_M, np.array([depth_m]), np.array([distance_m])
        )
        across_m = HEIGHT_M / cosine + depth_m / (index * refracted)
        along_m = HEIGHT_M / cosine**3 + depth_m / (index * refracted**3)
        spread_m = np.sqrt(across_m * along_m) * cosine
        path_m = HEIGHT_M / cosine + index * depth_m / refracted
        ray = -1j * frequency_hz * mu_0 / 2.0 * np.exp(-1j * wave * path_m) / spread_m
        electric = 2.0 * cosine / (cosine + index * refracted)
        magnetic = 2.0 * cosine / (refracted + index * cosine)
        beside = at_azimuth(parts[:, 0, 0], np.pi / 2.0)
        ahead = at_azimuth(parts[:, 0, 0], 0.0)
        assert beside[0] == pytest.approx(ray * electric, rel=0.02)
        turned = cosine * magnetic * ray
        assert ahead[0] == pytest.approx(turned * refracted, rel=0.02)
        assert ahead[2] == pytest.approx(-turned * np.sin(below), rel=0.02, abs=1e-3 * abs(ray))


@pytest.mark.parametrize("frequency_hz", [1e9, 5e9])
def test_over_a_perfect_conductor_the_echo_is_the_image_of_the_dipole(field, frequency_hz):
    echo = field.surface_echo(frequency_hz, -1e14j, HEIGHT_M, APART_M)
    image = -dipole_in_air(frequency_hz, (0.0, APART_M, 2.0 * HEIGHT_M))[0]
    assert echo == pytest.approx(image, rel=1e-6)
    beside = dipole_in_air(frequency_hz, (0.0, APART_M, 0.0))[0]
    assert field.coupling(frequency_hz, APART_M) == pytest.approx(beside, rel=1e-6)


def test_a_weak_disc_scatters_what_finite_differences_find(field, load):
    """To the error of a coarse grid, whose edges are close, on this small domain."""
    area, lines, bodies = (load(one) for one in ("area_field", "line_field", "born_body"))
    cell_m, soil, weak = 0.005, 4.0, 4.4
    half, above, deep = 38, 20, 72
    surface, apart, radius, thickness, top = above + 12, 12, 4, 4, 8
    ground = np.zeros((deep, 2 * half + 1, 2 * half + 1), np.uint8)
    ground[surface:] = 1
    source = half - apart // 2
    step_s = area.step_s(cell_m)
    sent = lines.pulse(2e9, step_s, round(2.8e-9 / step_s))
    frequency_hz = np.array([1.5e9, 2e9])
    materials = lines.Materials(np.array([1.0, soil, weak]), np.zeros(3))
    own = np.arange(2 * half + 1)
    disc = np.hypot(own[:, None] - half, own - half) < radius
    found = []
    for is_there in (False, True):
        if is_there:
            ground[surface + top : surface + top + thickness, disc] = 2
        boxes = area.Boxes(
            ground, np.zeros((1, 2), int), ground.shape,
            (above, half, source), (above, half, source + apart),
        )  # fmt: skip
        echo = area.received(boxes, materials, cell_m, sent, False)
        found.append(lines.transfer(echo, sent, step_s, frequency_hz)[0])
    scattered = (found[1] - found[0]) / (speed_of_light * epsilon_0 * cell_m**2)
    antennas = bodies.Antennas((surface - 0.5 - above) * cell_m, apart * cell_m, 1, cell_m)
    radii_m = np.full(thickness, np.sqrt(disc.sum() / np.pi) * cell_m)
    depth_m = (top + 0.5 + np.arange(thickness)) * cell_m
    for own_hz, value in zip(frequency_hz, scattered):
        layers = bodies.Layers(0.0, 0.0, depth_m, radii_m, cell_m)
        born = bodies.scattered(own_hz, soil + 0j, antennas, layers, cell_m / 2.0)[0, 0]
        assert value == pytest.approx(born * (weak - soil), rel=0.15)


def test_the_stored_scenes_are_those_that_are_drawn(load):
    draw = load("born_scenes").draw
    stored = truths(BORN)
    drawn = [asdict(draw(number)) for number in range(len(stored))]
    assert json.loads(json.dumps(drawn)) == stored
