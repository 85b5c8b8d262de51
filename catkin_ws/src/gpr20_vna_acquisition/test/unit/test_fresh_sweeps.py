"""Whatever the instrument's bit and timing are, every sweep is new at every point."""

from __future__ import annotations

import contextlib
import os
from dataclasses import replace

import pytest
from case_kit import each_case
from driver_bench import ADDRESS, SWEEP, Bench
from fault_kit import raises_fault
from freshness_kit import cells, drawn
from hypothesis import given
from hypothesis import strategies as st

from gpr20_survey.faults import PLAN_NOT_ALLOWED, VNA_FAILED
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_vna_acquisition.errors import VnaOldDataError, VnaSweepError
from gpr20_vna_acquisition.mid.sweep_timing import REMEMBERED, SweepEnd, SweepTiming

SECONDS = st.floats(0.0, 3.0)


def is_new(bench: Bench, triggered_after: int) -> bool:
    sweep = bench.driver.get_trace()
    numbers = set(sweep.s21_real)
    return len(numbers) == 1 and numbers.pop() > triggered_after


@given(
    sweep_s=SECONDS,
    stale_bit_s=SECONDS,
    exchange_s=st.floats(0.0001, 0.05),
    seconds_per_point=st.floats(0.0, 0.1),
)
def test_every_sweep_is_new_at_every_point(sweep_s, stale_bit_s, exchange_s, seconds_per_point):
    bench = Bench(seconds_per_point=seconds_per_point)
    bench.vna.sweep_s, bench.vna.stale_bit_s = sweep_s, stale_bit_s
    bench.vna.exchange_s = exchange_s
    bench.configured()
    for _ in range(4):
        assert is_new(bench, bench.vna.sweep_number)


@given(st.lists(st.tuples(SECONDS, SECONDS), min_size=2, max_size=6))
def test_no_point_is_old_when_the_instrument_changes_its_timing_without_notice(timings):
    bench = Bench(attempts=3)
    bench.vna.sweep_s, bench.vna.stale_bit_s = timings[0]
    bench.configured()
    for bench.vna.sweep_s, bench.vna.stale_bit_s in timings[1:]:
        before = bench.vna.sweep_number
        # An error is allowed; data of which a part is old are not.
        with contextlib.suppress(VnaSweepError):
            assert is_new(bench, before)


def test_a_bit_that_never_clears_is_not_believed_before_a_sweep_slower_than_expected_has_ended():
    bench = Bench()
    bench.vna.sweep_s, bench.vna.stale_bit_s = 5.0, 1e9
    bench.configured()
    assert 5.0 <= bench.driver.trace_duration_s < 8.0
    assert all(is_new(bench, bench.vna.sweep_number) for _ in range(3))
    assert bench.driver.state.repeats == 0


def test_the_duration_is_measured_again_when_a_setting_changes():
    bench = Bench().configured()
    bench.vna.sweep_s = 5.0
    narrow = AnalyzerSettings(if_bandwidth_hz=10.0)
    bench.driver.set_frequency_sweep(replace(SWEEP, analyzer=narrow))
    assert 5.0 <= bench.driver.trace_duration_s < 5.1
    assert is_new(bench, bench.vna.sweep_number)


@pytest.mark.parametrize("at_once", [True, False])
def test_an_average_has_all_its_sweeps_and_no_other(at_once):
    bench = Bench()
    bench.vna.averages_at_once = at_once
    bench.vna.settings[":SENS:AVER:COUN"] = "4"
    bench.configured()
    assert bench.driver.state.sweep.analyzer.averages == 4
    for _ in range(3):
        bench.vna.averaged = 99
        assert is_new(bench, bench.vna.sweep_number)
        assert bench.vna.averaged == 4


def test_an_average_that_cannot_be_begun_again_is_refused():
    bench = Bench()
    bench.vna.settings[":SENS:AVER:COUN"] = "4"
    take = bench.vna.take
    bench.vna.take = lambda message: [take(one) for one in message.split(";") if "CLE" not in one]
    bench.vna.averaged = 4
    with raises_fault(PLAN_NOT_ALLOWED, 4):
        bench.configured()


def test_a_display_that_stays_as_it_is_while_the_bit_never_clears_is_named_by_its_old_data():
    bench = Bench(attempts=2)
    bench.vna.sweep_s, bench.vna.stale_bit_s = 1e6, 1e9
    with raises_fault(VNA_FAILED, error=VnaSweepError):
        bench.configured()


@each_case("first, last", [(0, 12), (0, -2)])
def test_data_of_which_a_part_is_old_are_an_error_even_if_the_bit_was_seen_cleared(first, last):
    bench = Bench(attempts=1).configured()
    bench.driver.get_trace()
    partly_old = bench.vna.points_data()
    partly_old[first:last] = [99.0 + one for one in partly_old[first:last]]
    bench.vna.spoil = lambda answer: bench.vna.block(partly_old)
    with raises_fault(VNA_FAILED, error=VnaSweepError):
        bench.driver.get_trace()


# When the end of a sweep is asked for, after sweeps whose end came late.

USUAL_S, LATE_S = 0.2, 0.25


@each_case(
    "usual, late, expected_s",
    [
        # One late sweep among many does not delay those that follow.
        (REMEMBERED, 1, USUAL_S),
        (REMEMBERED, REMEMBERED // 4, LATE_S),
        # Soon after the settings changed every late sweep counts.
        (0, 1, LATE_S),
    ],
)
def test_sweeps_that_became_slower_are_expected_to_be_slow(usual, late, expected_s):
    def end(asked_s):
        return SweepEnd(asked_s, asked_s + 0.001, cleared=True)

    timing = SweepTiming([end(USUAL_S)])
    for asked_s in [USUAL_S] * usual + [LATE_S] * late:
        timing.note(end(asked_s), late=asked_s > USUAL_S)
    assert timing.expected_s == expected_s


# A display that follows the bit of the end of a sweep gives no data of an older sweep.

DATA = ":CALC1:DATA? SDAT"


def confirmed(bench: Bench) -> Sweep:
    """Return the next sweep that is confirmed, as the survey takes it."""
    for _ in range(4):
        number, sweep = bench.driver.take_sweep()
        try:
            bench.driver.confirm(number)
            return sweep
        except VnaOldDataError:
            continue
    raise AssertionError("no sweep was confirmed")


@given(
    late_s=st.floats(0.0, 1.15),
    sweep_s=st.floats(0.001, 1.0),
    stale_bit_s=st.floats(0.0, 1.0),
    exchange_s=st.floats(0.0001, 0.05),
    pauses_s=st.lists(st.floats(0.0, 3.0), min_size=4, max_size=8),
    continuous=st.booleans(),
)
def test_every_confirmed_sweep_is_new_however_late_the_display_is(
    late_s, sweep_s, stale_bit_s, exchange_s, pauses_s, continuous
):
    bench = Bench()
    bench.vna.late_memory_s, bench.vna.sweep_s = late_s, sweep_s
    bench.vna.stale_bit_s, bench.vna.exchange_s = stale_bit_s, exchange_s
    bench.driver.connect_to_vna(ADDRESS)
    if continuous:
        # A sweep that ended just before the hold is still to come.
        bench.vna.settings[":SENS:SWE:POIN"] = str(SWEEP.points)
        bench.vna.show_later(-7.0, late_s)
    bench.driver.set_frequency_sweep(SWEEP)
    for pause_s in pauses_s:
        bench.clock.pass_s(pause_s)
        before = bench.vna.sweep_number
        assert {one > before for one in confirmed(bench).s21_real} == {True}


def test_a_display_that_becomes_late_between_two_sweeps_gives_no_old_one():
    bench = Bench().configured()
    confirmed(bench)
    for late_s in (0.0, 0.003, 1.0, 0.05):
        bench.vna.set_late(late_s)
        before = bench.vna.sweep_number
        assert set(confirmed(bench).s21_real) == {before + 1.0}


def test_data_that_change_after_they_were_read_are_not_confirmed_and_measured_again():
    bench = Bench().configured()
    confirmed(bench)
    number, _sweep = bench.driver.take_sweep()
    bench.vna.spoil = lambda answer: bench.vna.block([1.0] * 22)
    with raises_fault(VNA_FAILED, error=VnaOldDataError):
        bench.driver.confirm(number)
    bench.vna.spoil = lambda answer: answer
    confirmed(bench)


def test_data_that_cannot_be_read_again_are_read_once_more():
    bench = Bench().configured()
    number, _sweep = bench.driver.take_sweep()
    spoilt = [lambda answer: answer[:-9]]
    bench.vna.spoil = lambda answer: spoilt.pop()(answer) if spoilt else answer
    del bench.vna.sent[:]
    bench.driver.confirm(number)
    assert bench.vna.sent.count(DATA) == 2


@pytest.mark.release
def test_no_confirmed_trace_is_stale_mixed_or_doubled():
    traces, chosen = int(os.environ.get("GPR20_FRESHNESS_TRACES", "2")), list(cells())
    counts = drawn(chosen, traces, workers=4)
    assert {one.traces for one in counts} == {traces}
    bad = [cell for cell, one in zip(chosen, counts) if one.stale or one.mixed or one.doubled]
    assert bad == []
