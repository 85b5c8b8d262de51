import dataclasses

import numpy as np
import pytest
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
    trace_at,
)

from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.echoes import MIN_BACKGROUND_TRACES, RadarModel
from gpr20_operator.ground.grid import Stop
from gpr20_operator.ground.records import Axis, Place, RadarSettings
from gpr20_operator.ground.sources import EchoSource
from gpr20_survey.plan.coverage import SampleState
from gpr20_survey.trace.trace_block import TraceBlock

LINEAR = RadarSettings(in_db=False, remove_background=False)


def filled(indices=None, s21_of=None, **changes):
    grid = make_grid()
    model = RadarModel()
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
    model = RadarModel()
    grid = make_grid()
    model.begin(grid)
    for index in range(10):
        height_m = 0.15 + 0.01 * index
        add_trace(model, trace_at(grid, index, depth_echo(0.1, height_m), height_m))
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
    model = RadarModel()
    model.begin(grid)
    add_trace(model, trace_at(grid, 0))  # at X 200
    picture = c_scan(model, LINEAR)
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


def one_by_one(grid, traces):
    model, reasons = RadarModel(), []
    model.begin(grid)
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
    single, reasons = one_by_one(grid, left)
    model, found = RadarModel(), []
    model.begin(grid)
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
    states[2] = SampleState.REMEASURED
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
