"""Sections and slices of the ground: each echo where it is, noise alone dark, a steady scale."""

import dataclasses

import numpy as np
import pytest
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from view_kit import (
    FREQUENCY_HZ,
    PAST,
    SURVEY,
    add_trace,
    b_scan,
    c_scan,
    depth_echo,
    make_grid,
    noise,
    trace_at,
)

from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.echoes import (
    MIN_BACKGROUND_TRACES,
    RadarModel,
    noise_threshold_db,
)
from gpr20_operator.ground.grid import Place, Stop
from gpr20_operator.ground.sources import Axis, EchoSource, RadarSettings
from gpr20_survey.trace.trace import TraceBlock

PLAIN = RadarSettings()
NOISE = 1e-4
TENTH = 0.1


def filled(indices=None, s21_of=None, grid=None, **changes):
    """Return a survey of which some traces are here; None: all. s21_of: of row and column."""
    grid, model = grid or make_grid(), RadarModel()
    model.begin(grid)
    for index in range(grid.planned) if indices is None else indices:
        row, column, _polarization = grid.cells(np.array(index))
        s21 = None if s21_of is None else s21_of(int(row), int(column))
        add_trace(model, trace_at(grid, index, s21, **changes))
    return model


@pytest.mark.parametrize("depth_m", [0.03, 0.1, 0.21])
def test_an_echo_is_at_its_depth_in_that_soil_below_its_own_height(depth_m):
    model = filled(())
    for index in range(10):
        height_m = 0.15 + 0.01 * index
        add_trace(model, trace_at(model.grid, index, depth_echo(depth_m, height_m), height_m))
    before = model.echoes.copy()
    for permittivity, factor in ((4.0, 1.0), (16.0, 0.5)):
        # Of a survey in which each stop has two heights, one per polarization.
        for polarization in range(2):
            view = dataclasses.replace(PLAIN, permittivity=permittivity, polarization=polarization)
            section = b_scan(model, Stop(0, 0), view)
            assert section.axis is Axis.DEPTH_MM
            places_mm = np.linspace(*section.range, len(section.shades) + 1)
            peaks_mm = places_mm[np.nanargmax(section.shades, axis=0)]
            assert peaks_mm == pytest.approx(depth_m * 1000 * factor, abs=8)
    assert (model.echoes == before).all()


def test_the_slice_shows_what_was_measured_where_it_is():
    def ground(row, column):
        return depth_echo(0.1, level=1.0 if (row, column) == (2, 3) else 0.01)

    picture = c_scan(filled(s21_of=ground), dataclasses.replace(PLAIN, depth_m=0.1))
    assert picture.axis is Axis.Y_MM
    assert np.unravel_index(np.argmax(picture.shades), picture.shades.shape) == (2, 3)
    assert picture.across_mm == pytest.approx((87.5, 212.5))
    assert picture.range == pytest.approx((40.0, 120.0))
    # A reverse survey lies where it was measured.
    grid = make_grid(x_start_mm=200.0, x_stop_mm=100.0)
    picture = c_scan(filled([0], grid=grid), PLAIN)  # at X 200
    assert picture.across_mm == pytest.approx((87.5, 212.5))
    assert np.isfinite(picture.shades[0, 4]) and np.isnan(picture.shades[0, 0])


def test_what_was_not_measured_is_never_a_level():
    model = filled(range(0, 40, 2))
    assert (np.isfinite(c_scan(model, PLAIN).shades) == model.present[0]).all()
    section = b_scan(model, Stop(1, 0), PLAIN)
    assert (np.isfinite(section.shades).any(axis=0) == model.present[0][1]).all()
    nothing = EchoSource(RadarModel())
    assert nothing.section(Place(0.0, 0.0), PLAIN) is None
    assert nothing.slice(PLAIN) is None


def test_background_removal_takes_the_surface_and_leaves_the_target():
    def ground(_row, column):
        return depth_echo(0.0) + (depth_echo(0.1, level=0.1) if column == 2 else 0.0)

    # The mean of one trace is the trace: the picture would be empty, and look like clear ground.
    few = filled(range(0, 2 * (MIN_BACKGROUND_TRACES - 1), 2), s21_of=ground)
    assert few.background(0) is None
    whole = filled(s21_of=ground)
    raw, clean = (b_scan(one, Stop(0, 0), PLAIN) for one in (few, whole))
    assert np.unravel_index(np.nanargmax(clean.shades), clean.shades.shape)[1] == 2
    surface = int(np.argmax(raw.shades[:, 0]))
    assert clean.shades[surface, 0] < 0.4 < 0.9 < raw.shades[surface, 0]
    # Once it is taken out, the scale is no longer that of the surface.
    for index in range(40):
        row, column, _polarization = few.grid.cells(np.array(index))
        add_trace(few, trace_at(few.grid, index, ground(int(row), int(column))))
    assert few.scale() == whole.scale()


def test_a_trace_that_does_not_belong_is_refused_and_not_asked_for_again():
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
        assert 3 in model.given_up and 3 not in model.absent(np.arange(40))
    with raises_fault(SurveyNotReadableError.fault, 3, PAST):
        add_trace(model, trace_at(make_grid(), 3, survey_id=PAST))


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
def test_a_block_is_the_same_as_its_traces_one_by_one_and_once(places, sizes, again):
    grid, chance = make_grid(), np.random.default_rng(len(places))
    traces = {}
    for index, changes in places:
        s21 = chance.standard_normal(501) + 1j * chance.standard_normal(501)
        height_m = float(chance.choice([0.2, 0.25, np.nan]))
        trace = dataclasses.replace(trace_at(grid, index, s21, height_m), **changes)
        traces[trace.index] = trace
    left = [*traces.values()] * (1 + again)
    single, reasons = one_by_one(traces.values())
    model, found = filled(()), []
    while left:
        size = min(sizes.pop(), len(traces)) if sizes else 1
        block, left = left[:size], left[size:]
        distinct = {one.index: one for one in block}
        found += model.add_block(TraceBlock.of(SURVEY, [*distinct.values()]))
    assert (model.count, model.given_up) == (single.count, single.given_up)
    assert set(found) == set(reasons)
    assert set(model.absent(np.arange(40))) == set(single.absent(np.arange(40)))
    for number in range(2):
        assert (model.present[number] == single.present[number]).all()
        assert model.echoes[number] == pytest.approx(single.echoes[number], abs=1e-6)
        assert model.heights_m(number) == pytest.approx(single.heights_m(number), nan_ok=True)
        if model.background(number) is not None:
            assert model.background(number) == pytest.approx(single.background(number), abs=1e-6)


def noisy(seed, size=(5, 4), ground=None, traces=None):
    """Return the survey of some ground below noise; without ground, of noise alone."""
    rng = np.random.default_rng(seed)

    def s21(row, column):
        return noise(rng, NOISE) + (0.0 if ground is None else ground(row, column))

    return filled(None if traces is None else range(traces), s21, make_grid(*size))


def brightest(model, settings):
    """Return the brightest shade of slices and sections."""
    source, along_y = EchoSource(model), dataclasses.replace(settings, along=Axis.Y_MM)
    views = [dataclasses.replace(settings, depth_m=one) for one in source.depths_m(settings)[::8]]
    found = [source.slice(one) for one in views]
    for number in range(0, min(model.grid.shape), 2):
        found.append(b_scan(model, Stop(number, 0), settings))
        found.append(b_scan(model, Stop(0, number), along_y))
    return max(float(np.nanmax(one.shades)) for one in found if one.measured)


def target_ground(level, at=(2, 2), surface=0.0):
    def s21(row, column):
        surface_echo = depth_echo(0.0, level=surface)
        return surface_echo + (depth_echo(0.1, level=level) if (row, column) == at else 0.0)

    return s21


def test_noise_alone_stays_below_a_tenth_of_the_scale():
    for seed in range(draws(6)):
        rng = np.random.default_rng(seed)
        size = ((3, 3), (5, 4), (8, 6))[seed % 3]
        # Also while the traces arrive, and beside a strong surface, once that is removed.
        surface = target_ground(0.0, surface=0.3) if seed % 2 else None
        planned = 2 * size[0] * size[1]
        traces = planned if surface else int(rng.integers(1, planned + 1))
        model = noisy(seed, size, surface, traces)
        settings = RadarSettings(permittivity=float(rng.uniform(1.0, 30.0)))
        assert brightest(model, settings) < TENTH, (seed, settings)
        alone = noisy(seed, size, None, traces).scale()
        assert model.scale().noise == pytest.approx(alone.noise, rel=0.1), seed


def test_a_target_stays_visible_and_its_slice_is_above_the_noise():
    # 20 dB above the highest noise of the pictures.
    level = NOISE * 10 ** ((noise_threshold_db(40 * 162) + 20.0) / 20.0) * 0.09
    for seed in range(draws(3)):
        model = noisy(seed, ground=target_ground(level))
        picture = c_scan(model, RadarSettings(depth_m=0.1))
        shades = picture.shades
        assert np.unravel_index(np.argmax(shades), shades.shape) == (2, 2), seed
        assert shades.max() > 0.5 and picture.above_noise, seed
        empty = c_scan(model, RadarSettings(depth_m=0.4))
        assert not empty.above_noise and empty.shades.max() < TENTH, seed
