"""A display that follows the bit of the end of a sweep gives no data of an older sweep."""

from __future__ import annotations

import dataclasses
import os

import pytest
from case_kit import each_case
from driver_bench import ADDRESS, SWEEP, Bench
from fault_kit import raises_fault
from freshness_kit import Cell, cells, drawn
from hypothesis import given
from hypothesis import strategies as st

from gpr20_survey.trace.sweep import Sweep
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaOldDataError, VnaSweepError
from gpr20_vna_acquisition.mid.vna_driver import VNADriver

DATA = ":CALC1:DATA? SDAT"
# More than the display may lag.
LONG_S = 1.2


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
    with raises_fault(faults.OLD_DATA, error=VnaOldDataError):
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


def test_only_the_first_confirmation_waits_until_the_display_must_have_followed():
    bench = Bench().configured()
    durations_s = []
    for _ in range(3):
        number, _sweep = bench.driver.take_sweep()
        begun_s = bench.clock.time_s
        bench.driver.confirm(number)
        durations_s.append(bench.clock.time_s - begun_s)
    assert durations_s[0] == pytest.approx(LONG_S, abs=0.01)
    assert max(durations_s[1:]) < 0.01


class Copying:
    """An analyzer of which every sweep has the same bits."""

    trace_duration_s, remarks, temperature_c = 0.1, (), None

    def __init__(self, bench: Bench, has_noise: bool) -> None:
        self._analyzer = bench.analyzer
        self.has_noise = has_noise
        self._sweep = None

    def __getattr__(self, name):
        return getattr(self._analyzer, name)

    def sweep(self):
        self._sweep = self._sweep or self._analyzer.sweep()
        return dataclasses.replace(self._sweep)


@each_case("has_noise", [True, False])
def test_a_sweep_with_every_bit_of_the_one_before_is_refused_unless_there_is_no_noise(has_noise):
    bench = Bench(attempts=2)
    parameters, deadline = bench.driver.parameters, bench.deadline
    driver = VNADriver(Copying(bench, has_noise), parameters, deadline, lambda _text: None)
    driver.connect_to_vna(ADDRESS)
    driver.set_frequency_sweep(SWEEP)
    driver.get_trace()
    if not has_noise:
        assert len(driver.get_trace().s21_real) == SWEEP.points
        return
    with raises_fault(faults.OLD_DATA, error=VnaSweepError):
        driver.get_trace()


@pytest.mark.release
def test_no_confirmed_trace_is_stale_mixed_or_doubled():
    # scripts/bench.sh freshness draws 2,000 from every kind.
    traces = int(os.environ.get("GPR20_FRESHNESS_TRACES", "2"))
    chosen = [cell for place, cell in enumerate(cells((51, 501))) if place % 4 == _turn(cell)]
    counts = drawn(chosen, traces, workers=14)
    assert len(chosen) == 14 and {one.traces for one in counts} == {traces}
    bad = [cell for cell, one in zip(chosen, counts) if one.stale or one.mixed or one.doubled]
    assert bad == []


def _turn(cell: Cell) -> int:
    """Return which format and number of points a delay is drawn with."""
    return round(1000 * cell.delay_s) % 4
