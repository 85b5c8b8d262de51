"""Whatever the instrument's bit and timing are, every sweep is new at every point."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import pytest
from case_kit import each_case
from driver_bench import SWEEP, Bench
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaSweepError
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
    with raises_fault(faults.NOT_AVERAGING, 4):
        bench.configured()


def test_a_display_that_stays_as_it_is_while_the_bit_never_clears_is_named_by_its_old_data():
    bench = Bench(attempts=2)
    bench.vna.sweep_s, bench.vna.stale_bit_s = 1e6, 1e9
    with raises_fault(faults.OLD_DATA, error=VnaSweepError):
        bench.configured()


@each_case("first, last", [(0, 12), (0, -2)])
def test_data_of_which_a_part_is_old_are_an_error_even_if_the_bit_was_seen_cleared(first, last):
    bench = Bench(attempts=1).configured()
    bench.driver.get_trace()
    partly_old = bench.vna.points_data()
    partly_old[first:last] = [99.0 + one for one in partly_old[first:last]]
    bench.vna.spoil = lambda answer: bench.vna.block(partly_old)
    with raises_fault(faults.OLD_DATA, error=VnaSweepError):
        bench.driver.get_trace()


def test_a_sweep_that_was_begun_again_is_remarked():
    bench = Bench(max_level_db=60.0)
    bench.vna.sweep_s = 0.175
    bench.configured()
    bench.driver.get_trace()
    bench.vna.sweep_s = 1.5 * 0.175
    (remark,) = bench.driver.get_trace().quality
    assert "put back" in remark
    bench.vna.sweep_s = 0.175
    assert bench.driver.get_trace().quality == ()


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
