"""One fresh sweep per request, or an error with the reason."""

from __future__ import annotations

import threading
from typing import List

import pytest
from driver_bench import STARTED_US, SWEEP, Bench
from fake_vna import FakeVna
from fault_kit import raises_fault

from gpr20_common.message import Message
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import (
    VnaConnectionError,
    VnaSweepError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.block_parser import TransferFormat


@pytest.fixture
def bench() -> Bench:
    return Bench().configured()


def _is_the_last_sweep(bench: Bench) -> bool:
    return bool((bench.driver.get_trace().s21_real == bench.vna.sweep_number).all())


def failing(times: int, when: str):
    """Break the link the next `times` times that a message beginning with `when` comes."""
    left = [times]

    def before(message: str) -> None:
        if message.startswith(when) and left[0] > 0:
            left[0] -= 1
            raise VnaConnectionError(Message("broken on purpose"))

    return before


@pytest.mark.parametrize("transfer", list(TransferFormat))
def test_a_sweep_is_one_new_sweep_with_both_parts(transfer):
    bench = Bench(transfer_format=transfer).configured()
    first = bench.vna.sweep_number
    for number in (1, 2, 3):
        sweep = bench.driver.get_trace()
        assert sweep.s21_real.tolist() == [float(first + number)] * 11
        assert sweep.s21_imag.tolist() == [float(point) for point in range(11)]


def test_reset_is_never_sent(bench):
    bench.driver.get_trace()
    bench.driver.check_calibration_status()
    bench.driver.disconnect_from_vna()
    assert not [message for message in bench.vna.sent if "RST" in message.upper()]


@pytest.mark.parametrize("sweep_s", [0.004, 0.05, 1.4])
def test_data_are_not_read_before_the_sweep_has_ended(sweep_s):
    bench = Bench().configured()
    bench.vna.sweep_s = sweep_s
    bench.driver.set_frequency_sweep(SWEEP)
    sweep = bench.driver.get_trace()
    assert (sweep.s21_real == bench.vna.sweep_number).all()
    assert sweep_s <= sweep.duration_s <= 1.3 * sweep_s + 0.02


def test_a_stale_bit_right_after_the_trigger_is_not_believed():
    bench = Bench(seconds_per_point=0.005).configured()
    bench.vna.stale_bit_s = 0.03
    assert _is_the_last_sweep(bench)


def test_a_bit_that_never_clears_is_believed_only_when_the_sweep_must_have_ended():
    bench = Bench(seconds_per_point=0.005).configured()
    bench.vna.stale_bit_s = 1e9
    sweep = bench.driver.get_trace()
    assert (sweep.s21_real == bench.vna.sweep_number).all()
    assert sweep.duration_s >= 0.055


def test_times_are_whole_microseconds_around_the_sweep(bench):
    sweep = bench.driver.get_trace()
    assert sweep.sweep_started_us == STARTED_US
    assert sweep.sweep_ended_us >= sweep.sweep_started_us + 50_000


def test_a_sweep_that_never_ends_is_given_up_within_its_limit():
    bench = Bench(sweep_timeout_s=2.0, attempts=1).configured()
    bench.vna.sweep_s = 1e9
    begun_s = bench.clock.time_s
    with raises_fault(faults.SWEEP_NOT_ENDED, error=VnaSweepError):
        bench.driver.get_trace()
    assert bench.clock.time_s - begun_s < 3.0


@pytest.mark.parametrize(
    "spoil",
    [
        lambda answer: answer[:-9],
        lambda answer: answer[:8] + b"\x00\x00\xc0\x7f" + answer[12:],
        lambda answer: b"\x8f\x01garbage",
        lambda answer: b"",
        lambda answer: answer.replace(b"#288", b"#284"),
    ],
    ids=["truncated", "nan", "garbage", "empty", "other length"],
)
def test_a_spoilt_answer_is_never_data_and_the_sweep_is_repeated(bench, spoil):
    spoilt = [spoil]
    bench.vna.spoil = lambda answer: spoilt.pop()(answer) if spoilt else answer
    assert _is_the_last_sweep(bench)
    assert len(bench.warnings) == 1


def test_after_so_many_spoilt_answers_the_sweep_fails_with_the_reason():
    bench = Bench(attempts=3).configured()
    bench.vna.spoil = lambda answer: answer[:-9]
    del bench.vna.sent[:]
    with raises_fault(faults.BAD_DATA, 3, error=VnaSweepError):
        bench.driver.get_trace()
    assert bench.vna.sent.count(":INIT:IMM") == 3
    bench.vna.spoil = lambda answer: answer
    assert _is_the_last_sweep(bench)


def test_the_same_data_twice_are_refused():
    bench = Bench(attempts=2).configured()
    bench.driver.get_trace()
    old = bench.vna.block(bench.vna.points_data())
    bench.vna.spoil = lambda answer: old
    with raises_fault(faults.OLD_DATA):
        bench.driver.get_trace()


def test_an_old_buffer_read_once_is_repeated_with_a_new_sweep(bench):
    first = bench.driver.get_trace()
    old = bench.vna.block([value for pair in zip(first.s21_real, first.s21_imag) for value in pair])
    stale = [old]
    bench.vna.spoil = lambda answer: stale.pop() if stale else answer
    assert _is_the_last_sweep(bench)


@pytest.mark.parametrize("when", [":INIT:IMM", ":STAT:OPER?", ":CALC1:DATA?", ":TRAC:PRE? 1"])
def test_a_broken_link_is_replaced_and_the_settings_compared(bench, when):
    bench.vna.before = failing(1, when)
    del bench.vna.sent[:]
    sweep = bench.driver.get_trace()
    assert (sweep.s21_real == bench.vna.sweep_number).all()
    assert bench.vna.links == 2 and bench.vna.open_links == 1
    assert "*IDN?" in bench.vna.sent and ":TRAC:PRE? 1" in bench.vna.sent
    # An instrument that kept its settings is not set up again: that may end its calibration.
    assert {one for one in bench.vna.sent if "?" not in one} == {"<lock>", "<clear>", ":INIT:IMM"}
    assert bench.driver.state.repeats == 1 and not bench.driver.state.last_error


def test_an_instrument_that_forgot_its_settings_is_set_up_again(bench):
    def power_cycle(message: str) -> None:
        if message == ":STAT:OPER?" and bench.vna.links == 1:
            bench.vna.settings = FakeVna(bench.clock).settings
            raise VnaConnectionError(Message("power lost"))

    bench.vna.before = power_cycle
    assert len(bench.driver.get_trace().s21_real) == 11
    assert bench.vna.settings[":SENS:TRACE1:SPAR"] == "S21"


def test_another_instrument_after_a_reconnection_is_refused(bench):
    bench.vna.before = failing(1, ":INIT:IMM")
    bench.vna.identity = '"Anritsu,MS2026C/2,7654321,1.23"'
    with raises_fault(faults.REPLACED, 7654321):
        bench.driver.get_trace()
    assert bench.vna.open_links == 0


@pytest.mark.parametrize(
    "header, value",
    [
        (":SENS:FREQ:STAR", "700000000"),
        (":SENS:TRACE1:SPAR", "S11"),
        (":INIT:CONT", "1"),
        (":SENS:TRACE1:DOM", "TIME"),
        (":SENS:AVER:COUN", "4"),
    ],
)
def test_a_hand_at_the_instrument_during_the_sweep_is_noticed(bench, header, value):
    done: List[str] = []

    def turn_knob(message: str) -> None:
        if message == ":CALC1:DATA? SDAT" and not done:
            done.append(message)
            bench.vna.settings[header] = value

    bench.vna.before = turn_knob
    assert _is_the_last_sweep(bench)
    assert header in bench.warnings[0]
    assert bench.vna.settings[":SENS:TRACE1:SPAR"] == "S21"


def test_exchanges_of_two_callers_do_not_mix(bench):
    results: List[float] = []

    def measure() -> None:
        for _ in range(20):
            sweep = bench.driver.get_trace()
            assert len(set(sweep.s21_real)) == 1
            results.append(sweep.s21_real[0])

    first = bench.vna.sweep_number
    threads = [threading.Thread(target=measure) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=20.0)
    assert sorted(results) == [float(first + number) for number in range(1, 61)]


def test_time_stamps_survive_a_correction_of_the_clock():
    bench = Bench().configured()
    walls_us = iter([STARTED_US, STARTED_US - 3_600_000_000])
    bench.analyzer._sweeps._utc_now_us = lambda: next(walls_us)
    assert 0.05 <= bench.driver.get_trace().duration_s < 0.1


def test_an_instrument_slow_at_every_step_is_given_up_within_the_requests_limit():
    bench = Bench(request_timeout_s=20.0, attempts=50).configured()
    bench.vna.spoil = lambda answer: answer[:-9]
    bench.vna.before = lambda message: bench.clock.pass_s(0.4)
    begun_s = bench.clock.time_s
    # The last attempt's fault says what to do, not that the time was over.
    with raises_fault(faults.BAD_DATA, 20.5, error=VnaTimeoutError):
        bench.driver.get_trace()
    assert bench.clock.time_s - begun_s < 21.0
    assert bench.vna.open_links == 0
    bench.vna.before = lambda message: None
    bench.vna.spoil = lambda answer: answer
    assert len(set(bench.driver.get_trace().s21_real)) == 1
