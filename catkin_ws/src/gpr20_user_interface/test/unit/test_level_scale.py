"""Noise alone stays dark, a target stays visible, and the scale stays where it is."""

import dataclasses
import itertools

import numpy as np
import pytest
from case_kit import each_case
from run_seed import draws
from view_kit import add_trace, b_scan, c_scan, depth_echo, make_grid, noise, trace_at

from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import Stop
from gpr20_operator.ground.level_scale import MIN_SPAN_DB, LevelScale, SteadyScale
from gpr20_operator.ground.records import Axis, Colours, RadarSettings
from gpr20_operator.ground.sources import depths_m
from gpr20_survey.radar.noise import noise_threshold_db

NOISE = 1e-4
TENTH = 0.1


def noisy(seed, size=(5, 4), ground=None, traces=None):
    """Return the survey of some ground below noise; without ground, of noise alone."""
    rng = np.random.default_rng(seed)
    grid = make_grid(*size)
    model = RadarModel()
    model.begin(grid)
    for index in range(grid.planned if traces is None else traces):
        echoes = 0.0 if ground is None else ground(grid.cell(index))
        add_trace(model, trace_at(grid, index, noise(rng, NOISE) + echoes))
    return model


def pictures(model, settings):
    for depth_m in depths_m(model, settings.permittivity)[::8]:
        yield c_scan(model, dataclasses.replace(settings, depth_m=float(depth_m)))
    along_y = dataclasses.replace(settings, along=Axis.Y_MM)
    for number in range(0, min(model.grid.shape), 2):
        yield b_scan(model, Stop(number, 0), settings)
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


def test_noise_alone_stays_below_a_tenth_of_the_scale():
    for seed in range(draws(6)):
        rng = np.random.default_rng(seed)
        model = noisy(seed, ((3, 3), (5, 4), (8, 6))[seed % 3])
        settings = RadarSettings(
            polarization=int(rng.integers(2)),
            in_depth=bool(rng.integers(2)),
            in_db=bool(rng.integers(2)),
            remove_background=bool(rng.integers(2)),
            permittivity=float(rng.uniform(1.0, 30.0)),
            gain_db_per_ns=float(rng.choice([0.0, 3.0, 10.0])),
            colours=Colours(rng.choice([one.value for one in Colours])),
        )
        assert brightest(model, settings) < TENTH, (seed, settings)


def test_noise_alone_stays_dark_beside_a_strong_surface_and_while_the_traces_arrive():
    beside = noisy(1, (8, 6), ground=target_ground(0.0, surface=0.3))
    for in_db in (True, False):
        assert brightest(beside, RadarSettings(in_db=in_db, gain_db_per_ns=6.0)) < TENTH
    for traces, remove in itertools.product((1, 5, 15, 16, 17, 30), (True, False)):
        model = noisy(traces, traces=traces)
        assert brightest(model, RadarSettings(remove_background=remove)) < TENTH, traces


def test_a_target_stays_visible_and_its_slice_is_above_the_noise():
    # 20 dB above the highest noise of the pictures.
    level = NOISE * 10 ** ((noise_threshold_db(40 * 162) + 20.0) / 20.0) * 0.09
    for seed in range(draws(3)):
        model = noisy(seed, ground=target_ground(level))
        for in_db, remove in itertools.product((True, False), repeat=2):
            settings = RadarSettings(in_db=in_db, remove_background=remove, depth_m=0.1)
            shades = c_scan(model, settings).shades
            assert np.unravel_index(np.argmax(shades), shades.shape) == (2, 2), seed
            assert shades.max() > (0.5 if in_db else 0.25), seed
            assert c_scan(model, settings).above_noise, seed
            empty = c_scan(model, dataclasses.replace(settings, depth_m=0.4))
            assert not empty.above_noise and empty.shades.max() < TENTH, seed


@each_case("remove", [True, False])
def test_every_slice_and_line_has_the_same_scale_which_is_steady_while_traces_arrive(remove):
    model = noisy(3, ground=target_ground(0.1, surface=0.5))
    settings = RadarSettings(remove_background=remove)
    assert len({one.scale for one in pictures(model, settings)}) == 1
    grid, ground = make_grid(16, 12), target_ground(0.01, surface=0.3)
    rng, scales = np.random.default_rng(4), []
    model.begin(grid)
    for index in range(grid.planned):
        # A surface that is not even, so that something of it remains.
        uneven = depth_echo(0.001 * rng.standard_normal(), level=0.3)
        s21 = noise(rng, NOISE) + uneven + ground(grid.cell(index))
        add_trace(model, trace_at(grid, index, s21))
        scales.append(model.scale(remove, in_db=True))
    tops = [one.top_db for one in scales[40:]]
    assert tops == sorted(tops)
    assert len(set(scales[20:])) <= 4 and len(set(scales[192:])) <= 2


def test_disturbed_traces_do_not_darken_the_others():
    def ground(place):
        burst = 30.0 if place.stop == Stop(0, 3) else 0.0
        return target_ground(0.01, 4, 4)(place) + depth_echo(0.2, level=burst)

    settings = RadarSettings(in_db=False, depth_m=0.1, remove_background=False)
    clean, disturbed = (noisy(5, (16, 12), one) for one in (target_ground(0.01, 4, 4), ground))
    one, other = clean.scale(False, True), disturbed.scale(False, True)
    assert other.top_db == one.top_db
    assert other.noise == pytest.approx(one.noise, rel=0.02)
    shades = [c_scan(model, settings).shades[4, 4] for model in (clean, disturbed)]
    assert shades[1] == pytest.approx(shades[0], rel=0.02)


def test_gain_a_linear_scale_and_silence_leave_noise_dark():
    scale = LevelScale(NOISE, threshold_db=12.0, top_db=60.0)
    for one in (scale, dataclasses.replace(scale, in_db=False)):
        assert one.shades(np.array([12.0]), np.array([150.0]))[0] < TENTH
        plain, gained = one.shades(np.array([30.0, 30.0]), np.array([0.0, 15.0]))
        assert gained > plain
    assert scale.shade_of(60.0) == 1.0
    silent = SteadyScale(1000)
    silent.update(0.0, 0.0)
    scale = silent.scale(in_db=True)
    assert scale.top_db >= scale.threshold_db + MIN_SPAN_DB
    assert scale.shades(scale.levels_db(np.zeros(3)), np.zeros(3)).tolist() == [0.0, 0.0, 0.0]
