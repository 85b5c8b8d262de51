"""The pictures of RADAR: each echo where it is, noise alone dark, a scale that stays."""

import dataclasses
import itertools

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from view_kit import (
    FREQUENCY_HZ,
    SURVEY,
    a_scan,
    add_trace,
    b_scan,
    c_scan,
    cell,
    depth_echo,
    make_grid,
    noise,
    trace_at,
)

from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.echoes import MIN_BACKGROUND_TRACES, RadarModel
from gpr20_operator.ground.grid import Stop
from gpr20_operator.ground.level_scale import MIN_SPAN_DB, LevelScale, SteadyScale
from gpr20_operator.ground.noise import (
    late_delays_s,
    late_kernel,
    noise_of_traces,
    noise_threshold_db,
)
from gpr20_operator.ground.records import Axis, Colours, Place, RadarSettings
from gpr20_operator.ground.sources import EchoSource, depths_m
from gpr20_survey.plan.survey_state import SampleState
from gpr20_survey.trace.trace_block import TraceBlock

LINEAR = RadarSettings(in_db=False, remove_background=False)


def filled(indices=None, s21_of=None, grid=None, **changes):
    """Return a survey of which some traces are here; None: all."""
    grid, model = grid or make_grid(), RadarModel()
    model.begin(grid)
    for index in range(grid.planned) if indices is None else indices:
        s21 = None if s21_of is None else s21_of(grid.cell(index))
        add_trace(model, trace_at(grid, index, s21, **changes))
    return model


@pytest.mark.parametrize("depth_m", [0.03, 0.1, 0.21])
def test_an_a_scan_peaks_at_the_depth_of_its_target_in_that_soil(depth_m):
    model = filled([0], s21_of=lambda _cell: depth_echo(depth_m))
    before = model.echoes[0].copy()
    for permittivity, factor in ((4.0, 1.0), (16.0, 0.5)):
        curve = a_scan(model, cell(0, 0), dataclasses.replace(LINEAR, permittivity=permittivity))
        assert curve.axis is Axis.DEPTH_MM
        peak_mm = curve.places[np.argmax(curve.shades)]
        assert peak_mm == pytest.approx(depth_m * 1000 * factor, abs=7)
    assert (model.echoes[0] == before).all()


def test_each_trace_counts_from_its_own_height():
    model = filled(())
    for index in range(10):
        height_m = 0.15 + 0.01 * index
        add_trace(model, trace_at(model.grid, index, depth_echo(0.1, height_m), height_m))
    line = b_scan(model, Stop(0, 0), LINEAR)
    peaks = np.linspace(*line.range, len(line.shades) + 1)[np.argmax(line.shades, axis=0)]
    assert peaks == pytest.approx(100.0, abs=8)


def test_the_slice_shows_what_was_measured_where_it_is():
    def ground(place):
        near = place.stop.row == 2 and place.stop.column == 3
        return depth_echo(0.1, level=1.0 if near else 0.01)

    picture = c_scan(filled(s21_of=ground), dataclasses.replace(LINEAR, depth_m=0.1))
    assert picture.axis is Axis.Y_MM
    assert np.unravel_index(np.argmax(picture.shades), picture.shades.shape) == (2, 3)
    assert picture.across_mm == pytest.approx((87.5, 212.5))
    assert picture.range == pytest.approx((40.0, 120.0))
    elsewhere = c_scan(filled(s21_of=ground), dataclasses.replace(LINEAR, depth_m=0.02))
    assert elsewhere.shades.max() < 0.05
    # A reverse survey lies where it was measured.
    grid = make_grid(x_start_mm=200.0, x_stop_mm=100.0)
    picture = c_scan(filled([0], grid=grid), LINEAR)  # at X 200
    assert picture.across_mm == pytest.approx((87.5, 212.5))
    assert np.isfinite(picture.shades[0, 4])
    assert np.isnan(picture.shades[0, 0])


def test_what_was_not_measured_is_never_a_level():
    model = filled(range(0, 40, 2))
    for in_db in (False, True):
        view = RadarSettings(in_db=in_db, remove_background=False)
        picture = c_scan(model, view)
        assert (np.isfinite(picture.shades) == model.present[0]).all()
        line = b_scan(model, Stop(1, 0), view)
        assert (np.isfinite(line.shades).any(axis=0) == model.present[0][1]).all()
    assert EchoSource(RadarModel()).line(Place(0.0, 0.0), LINEAR) is None
    assert c_scan(RadarModel(), LINEAR) is None
    assert a_scan(model, cell(0, 0, 1), LINEAR) is None


def test_background_removal_takes_the_surface_and_leaves_the_target():
    def ground(place):
        target = depth_echo(0.1, level=0.1) if place.stop.column == 2 else 0.0
        return depth_echo(0.0) + target

    model = filled(s21_of=ground)
    removed = RadarSettings(in_db=False, remove_background=True)
    raw, clean = b_scan(model, Stop(1, 0), LINEAR), b_scan(model, Stop(1, 0), removed)
    assert np.unravel_index(np.nanargmax(clean.shades), clean.shades.shape)[1] == 2
    assert np.nanmax(raw.shades) > 0.5
    surface = int(np.argmax(raw.shades[:, 0]))
    assert clean.shades[surface].max() < 0.1
    # The mean of one trace is the trace: the picture would be empty, and look like clear ground.
    indices = range(0, 2 * (MIN_BACKGROUND_TRACES - 1), 2)
    model = filled(indices)
    assert model.background(0) is None
    assert a_scan(model, model.latest, removed).shades.max() > 0.5


def test_gain_shows_later_echoes_stronger():
    model = filled(range(20), s21_of=lambda _cell: depth_echo(0.0) + depth_echo(0.4, level=1e-3))
    plain = RadarSettings(in_depth=False, remove_background=False)
    without = a_scan(model, cell(0, 0), plain)
    stronger = a_scan(model, cell(0, 0), dataclasses.replace(plain, gain_db_per_ns=3.0))
    assert stronger.axis is Axis.DELAY_NS
    late = np.argmin(np.abs(without.places - 6.67))
    assert stronger.shades[late] > without.shades[late] + 0.05
    assert (stronger.shades >= without.shades).all()
    assert stronger.scale == without.scale


def test_without_any_height_there_is_delay_but_no_depth():
    model = filled([0, 1], height_m=float("nan"))
    assert a_scan(model, cell(0, 0), LINEAR).axis is Axis.DELAY_NS
    assert b_scan(model, Stop(0, 0), LINEAR).axis is Axis.DELAY_NS
    assert c_scan(model, LINEAR) is None


def test_a_trace_may_come_twice():
    model = filled(range(20))
    once = model.background(0)
    add_trace(model, trace_at(make_grid(), 4))
    assert model.count == 20
    assert model.background(0) == pytest.approx(once, abs=1e-6)


def test_a_trace_that_does_not_belong_is_refused_and_not_asked_for_again():
    stored = np.full(40, SampleState.MEASURED, np.uint8)
    for changes in (
        {"x_coord_mm": 101.0},
        {"z_coord_deg": 90.0},
        {"frequency_hz": FREQUENCY_HZ + 1e6},
        {"frequency_hz": FREQUENCY_HZ[:300], "s21": np.zeros(300)},
    ):
        model = filled([0])
        with pytest.raises(SurveyNotReadableError):
            add_trace(model, trace_at(make_grid(), 3, **changes))
        assert not model.present[0][0, 1], changes
        assert 3 not in model.absent(stored)
        assert 3 in model.given_up
    with raises_fault(SurveyNotReadableError.fault, 3, "7c9e6679"):
        add_trace(model, trace_at(make_grid(), 3, survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7"))


def one_by_one(traces):
    model, reasons = filled(()), []
    for trace in traces:
        try:
            add_trace(model, trace)
        except SurveyNotReadableError as error:
            reasons.append(error.message)
    return model, reasons


ODD = st.sampled_from(
    [{}, {}, {}, {}, {"x_coord_mm": 101.0}, {"z_coord_deg": 45.0}, {"index": 40}, {"index": 999}]
)


@settings(max_examples=draws(13), deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 39), ODD), unique_by=lambda one: one[0], max_size=30),
    st.lists(st.integers(1, 12)),
    st.booleans(),
)
def test_a_block_is_the_same_as_its_traces_one_by_one(places, sizes, again):
    grid, chance = make_grid(), np.random.default_rng(len(places))
    traces = {}
    for index, changes in places:
        s21 = chance.standard_normal(501) + 1j * chance.standard_normal(501)
        height_m = float(chance.choice([0.2, 0.25, np.nan]))
        trace = dataclasses.replace(trace_at(grid, index, s21, height_m), **changes)
        traces[trace.index] = trace
    left = [*traces.values()] * (1 + again)
    single, reasons = one_by_one(left)
    model, found = filled(()), []
    while left:
        size = min(sizes.pop(), len(traces)) if sizes else 1
        block, left = left[:size], left[size:]
        distinct = {one.index: one for one in block}
        found += model.add_block(TraceBlock.of(SURVEY, [*distinct.values()]))
    assert (model.count, model.latest, model.latest_of) == (
        single.count,
        single.latest,
        single.latest_of,
    )
    assert model.given_up == single.given_up and set(found) == set(reasons)
    for number in range(2):
        assert (model.present[number] == single.present[number]).all()
        assert model.echoes[number] == pytest.approx(single.echoes[number], abs=1e-6)
        assert model.heights_m(number) == pytest.approx(single.heights_m(number), nan_ok=True)
        if model.background(number) is not None:
            assert model.background(number) == pytest.approx(single.background(number), abs=1e-6)


def test_it_knows_which_stored_traces_it_lacks():
    model = filled([0, 1, 5])
    states = np.zeros(40, np.uint8)
    states[:8] = SampleState.MEASURED
    states[3] = SampleState.FAILED
    assert model.absent(states).tolist() == [2, 4, 6, 7]
    model.give_up(4, "torn")
    assert model.absent(states).tolist() == [2, 6, 7]


def test_memory_is_bounded_whatever_the_plan():
    grid = make_grid(200, 200)
    model = RadarModel(max_bytes=8_000_000)
    model.begin(grid)
    add_trace(model, trace_at(grid, 0))
    used = sum(model.echoes[number].nbytes for number in range(2))
    assert used <= 8_000_000
    assert model.transform.samples == 12


NOISE = 1e-4
TENTH = 0.1


def noisy(seed, size=(5, 4), ground=None, traces=None):
    """Return the survey of some ground below noise; without ground, of noise alone."""
    rng = np.random.default_rng(seed)

    def s21(place):
        return noise(rng, NOISE) + (0.0 if ground is None else ground(place))

    return filled(None if traces is None else range(traces), s21, make_grid(*size))


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
    model = filled((), grid=grid)
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


def test_late_delays_hold_noise_and_not_the_echoes_of_the_ground():
    frequency_hz = np.linspace(0.6e9, 6.0e9, 501)
    late = late_kernel(frequency_hz)
    for delay_s, level in ((8e-9, 0.0), (late_delays_s(frequency_hz)[10], 1.0)):
        samples = np.exp(-2j * np.pi * frequency_hz * delay_s) @ late
        assert np.abs(samples).max() == pytest.approx(level, abs=1e-3)


def test_the_noise_of_a_trace_is_its_root_mean_square_also_beside_late_echoes():
    rng = np.random.default_rng(6)
    late = rng.standard_normal((4000, 2)) @ (1.0, 1.0j) * 3.0 / np.sqrt(2.0)
    assert noise_of_traces(late) == pytest.approx(3.0, rel=0.05)
    late[:400] += 1000.0
    assert noise_of_traces(late) == pytest.approx(3.0, rel=0.1)
