"""One fresh sweep per request, confirmed with its settings, or an error with the reason."""

from __future__ import annotations

import threading
from typing import List

import pytest
from case_kit import each_case
from driver_bench import ADDRESS, OTHER_IDENTITY, STARTED_US, SWEEP, Bench
from fault_kit import raises_fault

from gpr20_survey.faults import CAN_RESUME, VNA_FAILED, VNA_REPLACED, VNA_SETTINGS
from gpr20_vna_acquisition.errors import (
    VnaNotReadyError,
    VnaReplacedError,
    VnaSettingError,
    VnaSweepError,
)
from gpr20_vna_acquisition.mid.block_parser import TransferFormat
from gpr20_vna_acquisition.mid.vna_driver import VNADriver


@pytest.fixture
def bench() -> Bench:
    return Bench().configured()


def _is_the_last_sweep(bench: Bench) -> bool:
    return bool((bench.driver.get_trace().s21_real == bench.vna.sweep_number).all())


@pytest.mark.parametrize("transfer", list(TransferFormat))
def test_a_sweep_is_one_new_sweep_with_both_parts(transfer):
    bench = Bench(transfer_format=transfer).configured()
    first = bench.vna.sweep_number
    for number in (1, 2, 3):
        sweep = bench.driver.get_trace()
        assert sweep.s21_real.tolist() == [float(first + number)] * 11
        assert sweep.s21_imag.tolist() == [float(point) for point in range(11)]


def test_four_messages_take_a_sweep_and_three_confirm_it(bench):
    for _ in range(3):
        del bench.vna.sent[:]
        number = bench.taken
        assert bench.vna.sent == [":INIT:IMM", ":STAT:OPER?", ":STAT:OPER?", ":CALC1:DATA? SDAT"]
        del bench.vna.sent[:]
        bench.driver.confirm(number)
        assert bench.vna.sent == [":TRAC:PRE? 1", ":CALC1:DATA? SDAT", ":SENS:CORR:COLL:STAT:ACC?"]


def test_time_stamps_survive_a_correction_of_the_clock():
    bench = Bench().configured()
    walls_us = iter([STARTED_US, STARTED_US - 3_600_000_000])
    bench.analyzer._sweeps._utc_now_us = lambda: next(walls_us)
    sweep = bench.driver.get_trace()
    assert sweep.sweep_started_us == STARTED_US
    assert 0.05 <= sweep.duration_s < 0.1


def test_after_so_many_spoilt_answers_the_sweep_fails_with_the_reason():
    bench = Bench(attempts=3).configured()
    bench.vna.spoil = lambda answer: answer[:-9]
    del bench.vna.sent[:]
    with raises_fault(VNA_FAILED, 3, error=VnaSweepError):
        bench.driver.get_trace()
    assert bench.vna.sent.count(":INIT:IMM") == 3
    bench.vna.spoil = lambda answer: answer
    assert _is_the_last_sweep(bench)


def test_the_same_data_twice_are_refused():
    bench = Bench(attempts=2).configured()
    bench.driver.get_trace()
    old = bench.vna.block(bench.vna.points_data())
    bench.vna.spoil = lambda answer: old
    with raises_fault(VNA_FAILED):
        bench.driver.get_trace()
    # Once, it is repeated with a new sweep.
    stale = [old]
    bench.vna.spoil = lambda answer: stale.pop() if stale else answer
    assert _is_the_last_sweep(bench)


@each_case("when", [":INIT:IMM", ":STAT:OPER?", ":CALC1:DATA?", ":TRAC:PRE? 1"])
def test_a_broken_link_is_replaced_and_the_settings_compared(when):
    bench = Bench().configured()
    bench.lose_link_once(when)
    del bench.vna.sent[:]
    assert _is_the_last_sweep(bench)
    assert bench.vna.links == 2 and bench.vna.open_links == 1
    assert "*IDN?" in bench.vna.sent and ":TRAC:PRE? 1" in bench.vna.sent
    # An instrument that kept its settings is not set up again: that may end its calibration.
    assert {one for one in bench.vna.sent if "?" not in one} == {"<lock>", "<clear>", ":INIT:IMM"}
    assert bench.driver.state.repeats == 1 and not bench.driver.state.last_error


def test_another_serial_number_fails_the_request_at_once_until_it_is_connected(bench):
    bench.vna.identity = OTHER_IDENTITY
    bench.lose_link_once()
    begun_s = bench.clock.time_s
    with raises_fault(VNA_REPLACED, 7654321, 1234567):
        bench.driver.get_trace()
    assert bench.clock.time_s - begun_s < 1.0 and bench.vna.open_links == 0
    assert "7654321" in bench.driver.connect_to_vna(ADDRESS)
    bench.configured().driver.get_trace()


@each_case("says_its_serial_number", [True, False])
def test_another_instrument_on_the_same_link_is_noticed(says_its_serial_number):
    bench = Bench()
    if not says_its_serial_number:
        bench.vna.unanswered = [":TRAC:PRE? 1"]
    number = bench.configured().taken
    bench.vna.preamble["SN"] = "7654321"
    bench.vna.identity = OTHER_IDENTITY
    with raises_fault(VNA_REPLACED, 7654321, 1234567, error=VnaReplacedError):
        bench.driver.confirm(number)
    with raises_fault(VNA_REPLACED, 7654321, 1234567):
        bench.driver.take_sweep()


def test_exchanges_of_two_callers_do_not_mix(bench):
    results: List[float] = []

    def measure() -> None:
        for _ in range(10):
            sweep = bench.driver.get_trace()
            assert len(set(sweep.s21_real)) == 1
            results.append(sweep.s21_real[0])

    first = bench.vna.sweep_number
    threads = [threading.Thread(target=measure) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=30.0)
    assert sorted(results) == [float(first + number) for number in range(1, 31)]


# Confirmation.

HAND = {
    ":SENS:FREQ:STOP": "5000000000",
    ":SENS:SWE:POIN": "12",
    ":SENS:TRACE1:SPAR": "S11",
    ":SENS:TRACE1:DOM": "TIME",
    ":SENS:AVER:COUN": "4",
    ":SENS:SWE:IFBW": "20",
    ":FORM": "ASC",
    ":INIT:CONT": "1",
}


@each_case("header", list(HAND))
@each_case("is_broken", [False, True])
def test_a_sweep_is_not_confirmed_after_a_change_by_hand(header, is_broken):
    bench = Bench().configured()
    number, sweep = bench.driver.take_sweep()
    bench.vna.settings[header] = HAND[header]
    if is_broken:
        bench.lose_link_once()
    with raises_fault(VNA_SETTINGS):
        bench.driver.confirm(number)
    assert bench.vna.settings[header] == HAND[header], "nothing may be written to prove a sweep"
    number, again = bench.driver.take_sweep()
    assert again.analyzer == sweep.analyzer and bench.driver.confirm(number).remarks == ()
    assert bench.vna.settings[header] != HAND[header]
    # A trace is repeated.
    bench.vna.settings[header] = HAND[header]
    assert _is_the_last_sweep(bench)
    assert bench.vna.settings[header] != HAND[header]


@each_case(
    "name, asked",
    [("TRACE_1_STOP_FREQ", ":SENS:FREQ:STOP?"), ("DOMAIN", ":SENS:TRACE1:DOM?")],
)
def test_what_a_preamble_does_not_say_is_asked_for(name, asked):
    bench = Bench()
    bench.vna.left_out = name
    bench.configured()
    del bench.vna.sent[:]
    bench.driver.confirm(bench.taken)
    assert asked in bench.vna.sent
    number = bench.taken
    bench.vna.settings[asked[:-1]] = "17"
    with raises_fault(VNA_SETTINGS, error=VnaSettingError):
        bench.driver.confirm(number)


@each_case("name, value", [("SMOOTHING_PERCENT", "5.0"), ("TRACE_MATH_TYPES", "1")])
def test_a_trace_that_the_instrument_processes_is_refused(name, value):
    bench = Bench()
    bench.vna.preamble[name] = value
    with raises_fault(VNA_SETTINGS, error=VnaSettingError):
        bench.configured()
    bench.vna.preamble[name] = "0"
    number = bench.configured().taken
    bench.vna.preamble[name] = value
    with raises_fault(VNA_SETTINGS, name, error=VnaSettingError):
        bench.driver.confirm(number)


def test_the_temperature_of_the_instrument_is_in_quarters_of_a_degree(bench):
    def temperature_c():
        return bench.driver.confirm(bench.taken).temperature_c

    assert temperature_c() == 40.75
    bench.vna.preamble["CURRENT_TEMPERATURE"] = "-6"
    assert temperature_c() == -1.5
    # It is valid only with a calibration, and 0 is how the instrument says that it is applied.
    bench.vna.preamble["CAL_CORRECTION"] = "1"
    assert temperature_c() is None


def test_only_the_last_sweep_can_be_confirmed(bench):
    first, second = bench.taken, bench.taken
    with raises_fault(CAN_RESUME, first):
        bench.driver.confirm(first)
    with pytest.raises(VnaNotReadyError):
        bench.driver.confirm(second)


def restored(driver: VNADriver) -> None:
    """Make the settings again on a new link."""
    driver._link.drop()
    driver.check_calibration_status()


@each_case(
    "meanwhile",
    [
        lambda driver: driver.set_frequency_sweep(SWEEP),
        lambda driver: driver.connect_to_vna(ADDRESS),
        VNADriver.get_trace,
        restored,
    ],
)
def test_what_happens_before_the_confirmation_does_not_hide_a_change_by_hand(meanwhile):
    bench = Bench().configured()
    bench.vna.settings[":SENS:SWE:IFBW"] = "100"
    number = bench.taken
    meanwhile(bench.driver)
    with raises_fault(CAN_RESUME, number):
        bench.driver.confirm(number)


@pytest.mark.parametrize("is_changed", [True, False])
def test_the_check_of_an_idle_link_neither_hides_a_change_nor_hinders_the_confirmation(is_changed):
    bench = Bench().configured()
    if is_changed:
        bench.vna.settings[":SENS:SWE:IFBW"] = "100"
    number = bench.taken
    bench.driver._link.drop()
    bench.driver.test_connection()
    if not is_changed:
        assert bench.driver.confirm(number).remarks == ()
        return
    with raises_fault(VNA_SETTINGS):
        bench.driver.confirm(number)


def test_reset_is_never_sent(bench):
    bench.driver.get_trace()
    bench.driver.check_calibration_status()
    bench.driver.disconnect_from_vna()
    assert not [message for message in bench.vna.sent if "RST" in message.upper()]
