"""Whatever the instrument's bit, display and timing are, every confirmed sweep is new and whole."""

from __future__ import annotations

import contextlib
import itertools
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case
from driver_bench import (
    ADDRESS,
    DATA,
    PREAMBLE,
    STARTED_US,
    STATUS,
    SWEEP,
    TRIGGER,
    Bench,
    is_of_one_after,
)
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.simulated_analyzer import (
    CONNECT,
    AnalyzerOptions,
    SimulatedAnalyzer,
)
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe
from gpr20_simulator.mid.world.scene import InstrumentScene
from gpr20_survey.faults import VNA_FAILED
from gpr20_survey.trace.sweep import AnalyzerSettings, Sweep, SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaNotReadyError,
    VnaOldDataError,
    VnaSettingError,
    VnaSweepError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, connect
from gpr20_vna_acquisition.mid.block_parser import TransferFormat
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SECONDS = st.floats(0.0, 3.0)
# A display that lags by more than `display_settle_s` is not noticed.
LAGS_S = st.floats(0.0, 1.15)
WIRE_TRACES = int(os.environ.get("GPR20_FRESHNESS_TRACES", "2"))
SECONDS_PER_POINT = 20e-6
# What the survey measures again.
UNCONFIRMED = (VnaSettingError, VnaOldDataError, VnaNotReadyError)


def confirmed(driver: VNADriver) -> Sweep:
    """Return the next sweep that is confirmed, as the survey takes it."""
    for _ in range(5):
        number, sweep = driver.take_sweep()
        with contextlib.suppress(*UNCONFIRMED):
            driver.confirm(number)
            return sweep
    raise AssertionError("no sweep was confirmed")


@given(
    timings=st.lists(st.tuples(st.floats(0.001, 3.0), SECONDS, LAGS_S), min_size=1, max_size=4),
    is_set_up_again=st.booleans(),
    exchange_s=st.floats(0.0001, 0.05),
    seconds_per_point=st.floats(0.0, 0.1),
    pauses_s=st.lists(SECONDS, min_size=2, max_size=6),
    transfer=st.sampled_from(TransferFormat),
)
def test_every_confirmed_sweep_is_new_however_late_bit_and_display_are_and_become(
    timings, is_set_up_again, exchange_s, seconds_per_point, pauses_s, transfer
):
    bench = Bench(seconds_per_point=seconds_per_point, transfer_format=transfer, attempts=3)
    bench.before = lambda _message: bench.clock.sleep_until_s(bench.clock.now_s() + exchange_s)
    is_known = True
    for timing in timings:
        bench.takes(*timing)
        if is_known:
            bench.configured()
            # One from before the set-up, which may be shown after it.
            bench.by_hand(TRIGGER)
            bench.clock.sleep_until_s(bench.clock.now_s() + timing[0])
            bench.driver.set_frequency_sweep(SWEEP)
        for pause_s in pauses_s:
            bench.clock.sleep_until_s(bench.clock.now_s() + pause_s)
            before, errors = bench.number, () if is_known else (VnaSweepError, VnaTimeoutError)
            # After a change without notice an error is allowed; data that are old in part are not.
            with contextlib.suppress(*errors):
                assert is_of_one_after(confirmed(bench.driver), before)
        is_known = is_set_up_again


def test_a_bit_that_never_clears_is_not_believed_before_a_slow_sweep_has_ended():
    bench = Bench()
    bench.takes(5.0, stale_bit_s=1e9)
    bench.configured()
    assert 5.0 <= bench.driver.trace_duration_s < 8.0
    assert all(bench.is_new() for _ in range(3))
    assert bench.driver.state.repeats == 0


@given(st.integers(2, 9), LAGS_S)
def test_an_average_is_the_mean_of_new_sweeps_alone(averages, lag_s):
    bench = Bench()
    bench.takes(0.05, lag_s=lag_s)
    bench.driver.connect_to_vna(ADDRESS)
    # Averaging by the instrument is switched off: it could mix sweeps from before a move.
    bench.by_hand(":SENS:AVER:COUN 16")
    wanted = replace(SWEEP, analyzer=AnalyzerSettings(averages=averages))
    assert bench.driver.set_frequency_sweep(wanted).analyzer.averages == averages
    assert bench.driver.trace_duration_s >= averages * 0.05
    for _ in range(2):
        before = bench.number
        sweep = confirmed(bench.driver)
        assert sweep.analyzer.averages == averages and bench.ask(":SENS:AVER:COUN?") == "1"
        assert bench.number == before + averages
        mean = before + (averages + 1) / 2
        assert np.allclose(sweep.s21_real, mean, rtol=1e-6)
    assert bench.driver.set_frequency_sweep(SWEEP).analyzer.averages == 1


@each_case("first, last", [(0, 12), (0, -2)])
def test_data_of_which_a_part_is_old_are_an_error_even_if_the_bit_was_seen_cleared(first, last):
    bench = Bench(attempts=1).configured()
    bench.driver.get_trace()
    shown = np.frombuffer(bench.vna.instrument.execute(DATA.encode()).answer[4:-1], "<f4").copy()
    shown[first:last] += 99.0
    bench.answers(DATA, b"#288" + shown.tobytes())
    with raises_fault(VNA_FAILED, error=VnaSweepError):
        bench.driver.get_trace()


def test_a_confirmation_whose_data_are_spoilt_reads_them_again():
    bench = Bench().configured()
    number = bench.taken
    spoilt = [lambda answer: answer[:-9]]
    bench.answers(DATA, lambda right: spoilt.pop()(right) if spoilt else right)
    del bench.sent[:]
    bench.driver.confirm(number)
    assert bench.sent.count(DATA) == 2


@each_case(
    "attempts, stale, fault",
    [(2, "STALE", VNA_FAILED), (3, "TRUNCATE", VNA_FAILED), (2, "NAN", VNA_FAILED)],
)
def test_after_so_many_spoilt_sweeps_the_request_fails_with_the_reason(attempts, stale, fault):
    bench = Bench(attempts=attempts).configured()
    bench.driver.get_trace()
    bench.faults.set(stale, 1)
    # Once, it is repeated with a new sweep.
    assert bench.is_new()
    bench.faults.set(stale)
    del bench.sent[:]
    with raises_fault(fault, attempts, error=VnaSweepError):
        bench.driver.get_trace()
    assert bench.sent.count(CONNECT) == attempts - 1
    bench.faults.clear()
    assert bench.is_new()


def test_four_messages_take_a_sweep_and_three_confirm_it():
    bench = Bench().configured()
    bench.driver.get_trace()
    for _ in range(3):
        del bench.sent[:]
        number = bench.taken
        assert bench.sent == [TRIGGER, STATUS, STATUS, DATA]
        del bench.sent[:]
        bench.driver.confirm(number)
        assert bench.sent == [PREAMBLE, DATA, ":SENS:CORR:COLL:STAT:ACC?"]


def test_time_stamps_survive_a_correction_of_the_clock():
    bench = Bench()
    bench.takes(0.05)
    bench.configured()
    walls_us = iter([STARTED_US, STARTED_US - 3_600_000_000])
    bench.analyzer._sweeps._utc_now_us = lambda: next(walls_us)
    sweep = bench.driver.get_trace()
    assert sweep.sweep_started_us == STARTED_US
    assert 0.05 <= sweep.duration_s < 0.1


def wrong_over_the_wire(fault, delay_s, transfer, points):
    """Yield the traces with a point of another place, or of another sweep."""
    place, clock = [0.0], Clock()
    vna = SimulatedAnalyzer(
        PositionProbe(),
        lambda: AntennaPosition(place[0], 0.0, 0.0),
        clock,
        InstrumentScene(late_bit_s=delay_s, late_memory_s=delay_s),
        AnalyzerOptions(seconds_per_point=SECONDS_PER_POINT),
    )
    if delay_s:
        vna.faults.set(fault)
    vna.start()
    values = VnaParameters(transfer_format=transfer, seconds_per_point=SECONDS_PER_POINT)
    deadline, limits = RequestDeadline(clock), LinkLimits()
    analyzer = Ms2026c(lambda host: connect(host, limits, vna.server.port), values, deadline)
    driver, last = VNADriver(analyzer, values, deadline, print), []
    try:
        driver.connect_to_vna("127.0.0.1")
        driver.set_frequency_sweep(SweepSettings(600e6, 6e9, points))
        for number in range(WIRE_TRACES):
            # Single precision has it exactly.
            place[0] = number + 1.0
            sweep = confirmed(driver)
            numbers, places = sweep.s21_real.tolist(), set(sweep.s21_imag.tolist())
            if places != {place[0]} or len(set(numbers)) > 1 or numbers == last:
                yield fault, delay_s, transfer, points, number
            last = numbers
    finally:
        driver.shut_down()
        vna.stop()


@pytest.mark.release
def test_no_confirmed_trace_is_stale_mixed_or_doubled_over_the_wire():
    delays_s, points = (0.0, 0.001, 0.003, 0.01, 0.05, 0.2, 1.0), (51, 501, 4000)
    cells = itertools.product(("LATE_BIT", "LATE_MEMORY"), delays_s, TransferFormat, points)
    with ThreadPoolExecutor(4) as pool:
        found = [*pool.map(lambda cell: [*wrong_over_the_wire(*cell)], cells)]
    assert found == [[]] * 84
