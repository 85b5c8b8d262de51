"""The ground against delays found without Snell's law and simple limits, and its description."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from scipy import optimize

from gpr20_common.faults import NOT_ALLOWED
from gpr20_simulator.mid.faults import SceneError
from gpr20_simulator.mid.world.ground import (
    Ground,
    refracted_path,
    scatterers_of,
    sum_of_exponentials,
)
from gpr20_simulator.mid.world.medium import (
    AntennaPosition,
    PositionProbe,
    probed_position_mm,
    probed_rotation_deg,
    probed_sweep,
)
from gpr20_simulator.mid.world.scene import (
    Antennas,
    Noise,
    Scene,
    Shape,
    Soil,
    Surface,
    Target,
    read_scene,
)

C = 299_792_458.0
FREQUENCY_HZ = np.linspace(0.6e9, 6e9, 501)
QUIET = Noise(level_db=-300.0)
SILENT = Antennas(height_m=0.2, coupling_level_db=-200.0, surface_gain_db=-200.0)
LOSSLESS = Soil(relative_permittivity=4.0, loss_tangent=0.0)
OVER = AntennaPosition(100.0, 200.0, 0.0)


def point(**changes):
    """Return a line so short that it is a point, at (100, 200) mm."""
    values = dict(name="point", shape=Shape.LINE, x_mm=100.0, y_mm=200.0, depth_m=0.1, size_m=0.001)
    return Target(**{**values, **changes})


def ground(*targets, **changes):
    values = dict(soil=LOSSLESS, antennas=SILENT, noise=QUIET, targets=targets)
    return Ground(Scene(**{**values, **changes}))


def fermat_delay_s(height_m, depth_m, distance_m, permittivity):
    """Return the shortest time from antenna to point over all points of the surface."""
    index = math.sqrt(permittivity)

    def time_s(crossing_m):
        air_m = math.hypot(height_m, crossing_m)
        return (air_m + index * math.hypot(depth_m, distance_m - crossing_m)) / C

    return optimize.minimize_scalar(
        time_s, bounds=(0.0, distance_m), method="bounded", options={"xatol": 1e-10}
    ).fun


def strongest_delay_s(values, frequency_hz=FREQUENCY_HZ):
    """Return the delay of the strongest echo, by an inverse transform at true frequencies."""
    step_hz = frequency_hz[1] - frequency_hz[0]
    first = round(frequency_hz[0] / step_hz)
    length = 1 << 17
    spectrum = np.zeros(length, dtype=complex)
    spectrum[first : first + len(values)] = values * np.hanning(len(values))
    envelope = np.abs(np.fft.ifft(spectrum))
    return np.argmax(envelope) / (length * step_hz)


@given(
    height_m=st.floats(0.05, 0.6),
    depth_m=st.floats(0.001, 1.0),
    distance_m=st.floats(0.0, 2.0),
    permittivity=st.floats(1.0, 81.0),
)
def test_refraction_finds_the_quickest_way(height_m, depth_m, distance_m, permittivity):
    path = refracted_path(height_m, np.array([depth_m]), np.array([distance_m]), permittivity)
    delay_s = (path.air_m[0] + math.sqrt(permittivity) * path.soil_m[0]) / C
    expected_s = fermat_delay_s(height_m, depth_m, distance_m, permittivity)
    assert delay_s == pytest.approx(expected_s, rel=1e-9)


@each_case("x_mm, y_mm", [(100.0, 200.0), (180.0, 200.0), (0.0, 80.0), (500.0, 700.0)])
@each_case("depth_m, permittivity", [(0.03, 16.0), (0.1, 4.0), (0.3, 2.0)])
def test_echo_of_a_target_comes_by_the_quickest_way(x_mm, y_mm, depth_m, permittivity):
    here = AntennaPosition(x_mm, y_mm, 0.0)
    one = ground(point(depth_m=depth_m), soil=Soil(permittivity, 0.0))
    values = one.s21(FREQUENCY_HZ, here, 1)
    distance_m = math.hypot(x_mm - 100.0, y_mm - 200.0) / 1000.0
    expected_s = 2.0 * fermat_delay_s(0.2, depth_m, distance_m, permittivity)
    assert strongest_delay_s(values) == pytest.approx(expected_s, abs=2e-12)
    # A sweep in slices is the sweep.
    parts = [one.s21(FREQUENCY_HZ[k : k + 100], here, 1) for k in range(0, 501, 100)]
    assert np.concatenate(parts) == pytest.approx(values, abs=1e-12)


def test_separated_antennas_see_both_ways():
    antennas = replace(SILENT, separation_m=0.06)
    # The pair lies along Y when it is turned by 90 deg.
    here = AntennaPosition(100.0, 290.0, 90.0)
    delay_s = ground(point(), antennas=antennas).echoes(here).delay_s[2:]
    ways_s = [fermat_delay_s(0.2, 0.1, distance_m, 4.0) for distance_m in (0.12, 0.06)]
    assert delay_s == pytest.approx(sum(ways_s), rel=1e-4)


def test_sphere_is_seen_at_its_near_side():
    sphere = point(shape=Shape.SPHERE, size_m=0.06)
    above = ground(sphere).s21(FREQUENCY_HZ, OVER, 1)
    assert strongest_delay_s(above) == pytest.approx(2.0 * (0.2 + 2.0 * 0.1) / C, abs=2e-12)
    beside = ground(sphere).s21(FREQUENCY_HZ, AntennaPosition(250.0, 200.0, 0.0), 1)
    expected_s = 2.0 * (fermat_delay_s(0.2, 0.13, 0.15, 4.0) - 2.0 * 0.03 / C)
    assert strongest_delay_s(beside) == pytest.approx(expected_s, abs=2e-12)


def test_surface_and_coupling_come_at_their_delays_and_levels():
    antennas = Antennas(
        height_m=0.2, coupling_level_db=-40.0, coupling_delay_s=5e-9, surface_gain_db=-200.0
    )
    coupled = ground(antennas=antennas).s21(FREQUENCY_HZ, OVER, 1)
    assert strongest_delay_s(coupled) == pytest.approx(5e-9, abs=2e-12)
    assert np.abs(coupled) == pytest.approx(0.01, rel=1e-6)
    antennas = Antennas(height_m=0.2, coupling_level_db=-200.0, surface_gain_db=-20.0)
    surface = ground(antennas=antennas).s21(FREQUENCY_HZ, OVER, 1)
    assert strongest_delay_s(surface) == pytest.approx(0.4 / C, abs=2e-12)
    # Reflection (1 - 2) / (1 + 2) after 0.4 m where the level is given for 0.1 m.
    level = -0.1 / 3.0 / 4.0
    expected = level * np.exp(-2j * np.pi * FREQUENCY_HZ * 0.4 / C)
    assert surface == pytest.approx(expected, abs=1e-9)


def quickest_delay_s(uneven, here, target, permittivity):
    """Return the shortest time from antenna to point over all points of an uneven surface."""
    top_m = uneven.antenna_height_m(here.x_mm, here.y_mm)
    top_m += uneven.surface_height_m(here.x_mm, here.y_mm)

    def time_s(crossing_mm):
        surface_m = uneven.surface_height_m(*crossing_mm)
        crossing_m = np.array([*crossing_mm / 1000.0, surface_m])
        antenna_m = np.array([here.x_mm / 1000.0, here.y_mm / 1000.0, top_m])
        target_m = np.array([target.x_mm / 1000.0, target.y_mm / 1000.0, -target.depth_m])
        air_m, soil_m = (np.linalg.norm(crossing_m - end) for end in (antenna_m, target_m))
        return (air_m + math.sqrt(permittivity) * soil_m) / C * 1e9

    return optimize.minimize(time_s, [target.x_mm, target.y_mm], method="Nelder-Mead",
                             options={"xatol": 1e-3, "fatol": 1e-9}).fun * 1e-9  # fmt: skip


@each_case("x_mm, y_mm", [(100.0, 200.0), (20.0, 260.0), (300.0, 100.0)])
@each_case(
    "surface, steepest",
    [
        (Surface(), 0.0),
        (Surface(slope_x=0.03), 0.03),
        (Surface(slope_x=-0.05, slope_y=0.05), 0.071),
        (Surface(slope_y=0.03, wave_amplitude_m=0.003, wave_length_m=0.5), 0.068),
    ],
)
def test_waves_cross_an_uneven_surface_by_the_quickest_way(surface, steepest, x_mm, y_mm):
    target, here = point(), AntennaPosition(x_mm, y_mm, 0.0)
    uneven = ground(target, surface=surface)
    delay_s = np.mean(uneven.echoes(here).delay_s[2:]) / 2.0
    # The surface is taken as level where it is crossed: its slope counts in its square only.
    allowed_m = 1e-6 + 0.5 * steepest**2
    assert delay_s == pytest.approx(quickest_delay_s(uneven, here, target, 4.0), abs=allowed_m / C)


@each_case(
    "x_pol_strength, rotation_deg, share", [(0.05, 0.0, 1.0), (0.05, 90.0, 0.0), (0.05, 60.0, 0.25)]
)
def test_a_line_is_seen_by_its_own_polarization(x_pol_strength, rotation_deg, share):
    wire = point(x_pol_strength=x_pol_strength, y_pol_strength=0.05 - x_pol_strength)
    here = AntennaPosition(100.0, 200.0, rotation_deg)
    full = ground(point(x_pol_strength=0.05, y_pol_strength=0.05)).s21(FREQUENCY_HZ, OVER, 1)
    assert ground(wire).s21(FREQUENCY_HZ, here, 1) == pytest.approx(share * full, abs=1e-9)


def test_lossy_soil_weakens_high_frequencies_by_the_known_amount():
    lossless = ground(point()).s21(FREQUENCY_HZ, OVER, 1)
    lossy = ground(point(), soil=Soil(4.0, 0.02)).s21(FREQUENCY_HZ, OVER, 1)
    # pi f sqrt(er) tan(delta) / c nepers per metre, over 0.1 m there and back.
    expected = np.exp(-np.pi * FREQUENCY_HZ * 2.0 * 0.02 / C * 0.2)
    assert np.abs(lossy / lossless) == pytest.approx(expected, rel=1e-6)


def test_noise_has_its_level_and_gain_and_is_the_same_for_the_same_seed():
    frequency_hz = np.linspace(1e9, 2e9, 20000)

    def noise(seed, gain=1.0):
        one = ground(noise=Noise(level_db=-60.0, seed=seed))
        return one.s21(frequency_hz, OVER, 1, gain)

    for gain in (0.1, 1.0, 10.0):
        level = np.sqrt(np.mean(np.abs(noise(7, gain)) ** 2))
        assert level == pytest.approx(gain * 1e-3, rel=0.03)
    assert abs(np.mean(noise(7) ** 2)) < 1e-7
    assert np.array_equal(noise(7), noise(7))
    assert not np.array_equal(noise(7), noise(8))


def test_disc_and_line_are_spread_over_their_size():
    disc = scatterers_of([point(shape=Shape.DISC, size_m=0.1)])
    radius_m = np.hypot(disc.x_m - 0.1, disc.y_m - 0.2)
    assert radius_m.max() == pytest.approx(0.05)
    assert disc.x_pol_strength.sum() == pytest.approx(0.05)
    line = scatterers_of([point(size_m=0.2, direction_deg=90.0)])
    assert np.ptp(line.y_m) == pytest.approx(0.2)
    assert np.ptp(line.x_m) == pytest.approx(0.0, abs=1e-12)
    assert np.max(np.diff(line.y_m)) <= 0.012 + 1e-9


@given(st.integers(0, 16_000_000), st.integers(0, 999), st.integers(0, 999), st.integers(-50, 50))
def test_probe_tells_sweep_position_and_rotation_even_after_float32(number, x_mm, y_mm, step):
    position = AntennaPosition(float(x_mm), float(y_mm), step * 1.8)
    values = PositionProbe().s21(FREQUENCY_HZ[:3], position, number).astype(np.complex64)
    for value in values:
        assert probed_sweep(value) == number % 65_536
        assert probed_position_mm(value) == (x_mm, y_mm)
        assert probed_rotation_deg(value) == pytest.approx(position.rotation_deg, abs=0.4)


@given(
    st.integers(1, 4001),
    st.integers(1, 4001),
    st.sampled_from([0.0, 1.0]),
    st.integers(0, 2**32 - 1),
)
def test_a_sweep_is_the_sum_of_its_echoes_however_it_is_computed(points, end, uneven, seed):
    random = np.random.default_rng(seed)
    frequency_hz = np.linspace(600e6, 6e9, points)[:end]
    frequency_hz += uneven * random.normal(0.0, 1e5, len(frequency_hz))
    rate_s = -2j * np.pi * random.uniform(0.0, 2e-8, 5) - random.uniform(0.0, 1e-10, 5)
    level = random.normal(size=5)
    expected = np.exp(np.outer(frequency_hz, rate_s)) @ level
    found = sum_of_exponentials(frequency_hz, rate_s, level)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11)


# Its description.

SCENES = Path(__file__).parents[2] / "scenes"

TARGET = "targets: [{name: a, shape: sphere, x_mm: 1, y_mm: 2, depth_m: 0.1%s}]"


def scene_from(tmp_path, text):
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return read_scene(str(path))


@each_case("name", ["two_targets", "three_targets"])
def test_scenes_of_the_package_have_targets_that_stand_out_of_the_noise(name):
    scene = read_scene(str(SCENES / f"{name}.yaml"))
    assert scene.name == name
    values = Ground(scene).s21(FREQUENCY_HZ, AntennaPosition(150.0, 150.0, 0.0), 1)
    assert np.max(np.abs(values)) < 0.1
    for target in scene.targets if name == "two_targets" else ():
        over = AntennaPosition(target.x_mm, target.y_mm, 0.0)
        strongest = np.abs(np.sum(Ground(scene).echoes(over).level[2:]))
        assert strongest > 20.0 * 10.0 ** (scene.noise.level_db / 20.0)


@each_case(
    "text, shown",
    [
        ("soil: {permitivity: 4}", ("scene/soil/permitivity", "loss_tangent")),
        ("soil: {relative_permittivity: 0.5}", ("relative_permittivity", 0.5, 1, 81)),
        ("soil: {relative_permittivity: .nan}", ("relative_permittivity", "nan")),
        ("soil: {relative_permittivity: four}", ("'four'",)),
        ("targets: [{name: a, shape: sphere, x_mm: 1, y_mm: 2}]", ("depth_m",)),
        (TARGET.replace("sphere", "cube") % "", ("'cube'", "sphere, disc, line")),
        (TARGET % ", size_m: 3", ("targets[0]/size_m", 3)),
        (TARGET % "" + "\nsurface: {slope_x: 0.2}", ()),
        ("surface: {wave_amplitude_m: 0.1}\nantennas: {height_m: 0.1}", ()),
        ("robot: {x: {start: -4}}", ("robot.x.start", -4)),
        ("!!python/object/apply:os.getcwd []", ()),
    ],
)
def test_wrong_scene_says_which_key_and_what_is_allowed(tmp_path, text, shown):
    with raises_fault(NOT_ALLOWED, *shown, error=SceneError):
        scene_from(tmp_path, text)
