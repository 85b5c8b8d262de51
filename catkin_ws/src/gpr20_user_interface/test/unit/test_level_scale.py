"""Noise alone stays dark, a target stays visible, and the scale stays where it is."""

import dataclasses
import itertools
import os

import numpy as np
import pytest
from view_kit import a_scan, add_trace, b_scan, c_scan, depth_echo, make_grid, trace_at

from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import Stop
from gpr20_operator.ground.level_scale import MIN_SPAN_DB, LevelScale, SteadyScale
from gpr20_operator.ground.records import Axis, Colours, RadarSettings
from gpr20_operator.ground.sources import EchoSource, depths_m
from gpr20_survey.radar.noise import noise_threshold_db

# More draws: GPR20_SEEDS=500.
SEEDS = range(int(os.environ.get("GPR20_SEEDS", "12")))
SIZES = ((3, 3), (5, 4), (16, 12))
NOISE = 1e-4
TENTH = 0.1


def noise(rng, points=501):
    return NOISE * (rng.standard_normal(points) + 1j * rng.standard_normal(points))


def noisy(seed, size=(5, 4), ground=None, traces=None):
    """Return the survey of some ground below noise; without ground, of noise alone."""
    rng = np.random.default_rng(seed)
    grid = make_grid(*size)
    model = RadarModel()
    model.begin(grid)
    for index in range(grid.planned if traces is None else traces):
        s21 = noise(rng)
        add_trace(
            model, trace_at(grid, index, s21 if ground is None else s21 + ground(grid.cell(index)))
        )
    return model


def pictures(model, settings):
    """Yield every slice and line."""
    for depth_m in depths_m(model, settings.permittivity)[::4]:
        yield c_scan(model, dataclasses.replace(settings, depth_m=float(depth_m)))
    rows, columns = model.grid.shape
    for number in range(rows):
        yield b_scan(model, Stop(number, 0), settings)
    for number in range(columns):
        along_y = dataclasses.replace(settings, along=Axis.Y_MM)
        yield b_scan(model, Stop(0, number), along_y)


def brightest(model, settings):
    shown = (one.shades for one in pictures(model, settings) if one.measured)
    return max(float(np.nanmax(np.abs(shades))) for shades in shown)


def target_ground(level, row=2, column=2, surface=0.0):
    def s21(place):
        here = place.stop.row == row and place.stop.column == column
        surface_echo = depth_echo(0.0, level=surface)
        return surface_echo + (depth_echo(0.1, level=level) if here else 0.0)

    return s21


@pytest.mark.parametrize("size", SIZES)
def test_noise_alone_stays_below_a_tenth_of_the_scale(size):
    for seed in SEEDS:
        model = noisy(seed, size)
        rng = np.random.default_rng(seed)
        for remove in (True, False):
            settings = RadarSettings(
                polarization=int(rng.integers(2)),
                in_depth=bool(rng.integers(2)),
                in_db=bool(rng.integers(2)),
                remove_background=remove,
                permittivity=float(rng.uniform(1.0, 30.0)),
                gain_db_per_ns=float(rng.choice([0.0, 3.0, 10.0])),
                colours=Colours(rng.choice([one.value for one in Colours])),
            )
            assert brightest(model, settings) < TENTH, (seed, settings)


def test_noise_alone_beside_a_strong_surface_stays_dark():
    model = noisy(1, (16, 12), ground=target_ground(0.0, surface=0.3))
    for in_db in (True, False):
        settings = RadarSettings(in_db=in_db, gain_db_per_ns=6.0)
        assert brightest(model, settings) < TENTH


def test_noise_alone_stays_dark_while_the_traces_arrive():
    for traces in (1, 2, 5, 9, 14, 15, 16, 17, 30):
        for remove in (True, False):
            model = noisy(traces, traces=traces)
            assert brightest(model, RadarSettings(remove_background=remove)) < TENTH, traces


def test_a_target_stays_visible_and_its_slice_is_above_the_noise():
    # 20 dB above the highest noise of the pictures.
    level = NOISE * 10 ** ((noise_threshold_db(40 * 162) + 20.0) / 20.0) * 0.09
    for seed in SEEDS:
        model = noisy(seed, ground=target_ground(level))
        for in_db, remove in itertools.product((True, False), repeat=2):
            settings = RadarSettings(in_db=in_db, remove_background=remove, depth_m=0.1)
            picture = c_scan(model, settings)
            brightest_at = np.unravel_index(np.argmax(picture.shades), picture.shades.shape)
            assert brightest_at == (2, 2), seed
            assert picture.shades.max() > (0.5 if in_db else 0.25), seed
            assert picture.above_noise, seed
            empty = c_scan(model, dataclasses.replace(settings, depth_m=0.4))
            assert not empty.above_noise, seed
            assert empty.shades.max() < TENTH, seed


def test_every_slice_and_line_has_the_same_scale():
    model = noisy(3, ground=target_ground(0.1, surface=0.5))
    scales = {one.scale for one in pictures(model, RadarSettings())}
    assert len(scales) == 1


def test_the_scale_is_steady_while_traces_arrive():
    grid = make_grid(16, 12)
    rng = np.random.default_rng(4)
    ground = target_ground(0.01, surface=0.3)
    for remove in (True, False):
        model = RadarModel()
        model.begin(grid)
        scales = []
        for index in range(grid.planned):
            cell = grid.cell(index)
            # A surface that is not even, so that something of it remains.
            uneven = depth_echo(0.001 * rng.standard_normal(), level=0.3)
            add_trace(model, trace_at(grid, index, noise(rng) + uneven + ground(cell)))
            scales.append(model.scale(remove, in_db=True))
        tops = [one.top_db for one in scales[40:]]
        assert tops == sorted(tops)
        assert len(set(scales[20:])) <= 4
        assert len(set(scales[192:])) <= 2


def test_disturbed_traces_do_not_darken_the_others():
    def ground(place):
        stop = place.stop
        burst = 30.0 if (stop.row, stop.column) in {(0, 3)} else 0.0
        return target_ground(0.01, 6, 6)(place) + depth_echo(0.2, level=burst)

    settings = RadarSettings(in_db=False, depth_m=0.1, remove_background=False)
    clean = noisy(5, (16, 12), ground=target_ground(0.01, 6, 6))
    disturbed = noisy(5, (16, 12), ground=ground)
    one, other = clean.scale(False, True), disturbed.scale(False, True)
    assert other.top_db == one.top_db
    assert other.noise == pytest.approx(one.noise, rel=0.02)
    shades = [c_scan(model, settings).shades[6, 6] for model in (clean, disturbed)]
    assert shades[1] == pytest.approx(shades[0], rel=0.02)


def test_gain_and_a_linear_scale_leave_noise_dark():
    scale = LevelScale(NOISE, threshold_db=12.0, top_db=60.0)
    for one in (scale, dataclasses.replace(scale, in_db=False)):
        for gain_db in (0.0, 10.0, 150.0):
            assert one.shades(np.array([12.0]), np.array([gain_db]))[0] < TENTH
        plain, gained = one.shades(np.array([30.0, 30.0]), np.array([0.0, 15.0]))
        assert gained > plain
    assert scale.shade_of(60.0) == 1.0
    assert scale.ticks_db().tolist() == [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]


def test_a_level_without_noise_has_a_scale_too():
    silent = SteadyScale(1000)
    silent.update(0.0, 0.0)
    scale = silent.scale(in_db=True)
    assert scale.top_db >= scale.threshold_db + MIN_SPAN_DB
    assert scale.shades(scale.levels_db(np.zeros(3)), np.zeros(3)).tolist() == [0.0, 0.0, 0.0]


def test_the_level_of_the_crosshair_is_that_of_the_echo_above_the_noise():
    model = noisy(7, ground=target_ground(0.01))
    settings = RadarSettings(depth_m=0.1, remove_background=False, gain_db_per_ns=10.0)
    floor = model.scale(False, True).noise
    source, place = EchoSource(model), model.grid.place_of(Stop(2, 2))
    expected = 20 * np.log10(0.01 / floor)
    assert source.level_db(place, settings) == pytest.approx(expected, abs=0.6)
    assert EchoSource(RadarModel()).level_db(place, settings) is None


def test_a_signed_curve_has_both_signs_and_the_same_envelope():
    model = noisy(8, ground=target_ground(0.1))
    cell = model.grid.cell(model.grid.index(model.latest))
    for colours in (Colours.GREY, Colours.RED_WHITE_BLUE):
        signed = c_scan(model, RadarSettings(colours=colours, depth_m=0.1, in_db=False))
        envelope = c_scan(model, RadarSettings(depth_m=0.1, in_db=False))
        assert (np.abs(signed.shades) <= envelope.shades + 1e-6).all()
        curve = a_scan(model, cell, RadarSettings(colours=colours))
        assert curve.signed
    target = dataclasses.replace(model.latest, stop=Stop(2, 2), polarization=0)
    curve = a_scan(model, target, RadarSettings(colours=Colours.GREY, in_db=False))
    assert curve.shades.min() < -0.3 < 0.3 < curve.shades.max()
