"""A sweep is confirmed with its settings, by the instrument that made it, or not at all."""

from __future__ import annotations

import threading
from typing import List

import pytest
from case_kit import each_case
from driver_bench import ADDRESS, PREAMBLE, SWEEP, Bench
from fault_kit import raises_fault

from gpr20_simulator.mid.analyzer.in_process import CLEAR, CONNECT, LOCK
from gpr20_survey.faults import CAN_RESUME, VNA_REPLACED, VNA_SETTINGS
from gpr20_vna_acquisition.errors import VnaNotReadyError, VnaReplacedError, VnaSettingError
from gpr20_vna_acquisition.mid.vna_driver import VNADriver

# What somebody may set, beside what the driver sets.
HAND = {
    ":SENS:FREQ:STOP": "5000000000",
    ":SENS:SWE:POIN": "12",
    ":SENS:TRACE1:SPAR": "S11",
    ":SENS:TRACE1:DOM": "TIME",
    ":SENS:AVER:COUN": "4",
    ":SENS:SWE:IFBW": "20",
    ":SOUR:POW": "LOW",
    ":FORM": "ASC",
    ":INIT:CONT": "ON",
}


@pytest.fixture
def bench() -> Bench:
    return Bench().configured()


@each_case("header", list(HAND))
@each_case("is_broken", [False, True])
def test_a_sweep_is_not_confirmed_after_a_change_by_hand(header, is_broken):
    bench = Bench().configured()
    number, sweep = bench.driver.take_sweep()
    before = bench.ask(f"{header}?")
    bench.by_hand(f"{header} {HAND[header]}")
    changed = bench.ask(f"{header}?")
    if is_broken:
        bench.lose_link_once()
    with raises_fault(VNA_SETTINGS):
        bench.driver.confirm(number)
    assert bench.ask(f"{header}?") == changed != before, "nothing may be written to prove a sweep"
    number, again = bench.driver.take_sweep()
    assert again.analyzer == sweep.analyzer and bench.driver.confirm(number).remarks == ()
    assert bench.ask(f"{header}?") == before and bench.is_new()


@each_case(
    "name, asked",
    [("TRACE_1_STOP_FREQ", ":SENS:FREQ:STOP"), ("TRACE_DOMAIN_TYPES", ":SENS:TRACE1:DOM")],
)
def test_what_a_preamble_does_not_say_is_asked_for(name, asked):
    bench = Bench()
    others = [name.encode(), b"DOMAIN"]

    def renamed(right: bytes) -> bytes:
        for one in others:
            right = right.replace(b"," + one + b"=", b"," + b"X" * len(one) + b"=")
        return right

    bench.answers(PREAMBLE, renamed)
    bench.configured()
    bench.driver.confirm(bench.taken)
    assert f"{asked}?" in bench.sent
    number = bench.taken
    bench.by_hand(f"{asked} {HAND[asked]}")
    with raises_fault(VNA_SETTINGS, error=VnaSettingError):
        bench.driver.confirm(number)


@each_case("name, value", [("SMOOTHING_PERCENT", 5), ("TRACE_MATH_TYPES", 1)])
def test_a_trace_that_the_instrument_processes_is_refused(name, value):
    def spoil(right: bytes) -> bytes:
        return right.replace(b"%s=0" % name.encode(), b"%s=%d" % (name.encode(), value))

    bench = Bench()
    bench.answers(PREAMBLE, spoil)
    with raises_fault(VNA_SETTINGS, error=VnaSettingError):
        bench.configured()
    bench.answers(PREAMBLE, lambda right: right)
    number = bench.configured().taken
    bench.answers(PREAMBLE, spoil)
    with raises_fault(VNA_SETTINGS, name, error=VnaSettingError):
        bench.driver.confirm(number)


def test_the_temperature_of_the_instrument_is_in_quarters_of_a_degree(bench):
    def temperature_c():
        return bench.driver.confirm(bench.taken).temperature_c

    assert temperature_c() == 40.0
    bench.answers(PREAMBLE, lambda right: right.replace(b"TURE=160", b"TURE= -6"))
    assert temperature_c() == -1.5
    # It is valid only with a calibration.
    bench.answers(PREAMBLE, lambda right: right.replace(b"CORRECTION=0", b"CORRECTION=1"))
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
    bench.by_hand(":SENS:SWE:IFBW 100")
    number = bench.taken
    try:
        meanwhile(bench.driver)
    except VnaSettingError:
        assert meanwhile is VNADriver.get_trace
    with raises_fault(CAN_RESUME, number):
        bench.driver.confirm(number)


@pytest.mark.parametrize("is_changed", [True, False])
def test_the_check_of_an_idle_link_neither_hides_a_change_nor_hinders_the_confirmation(is_changed):
    bench = Bench().configured()
    if is_changed:
        bench.by_hand(":SENS:SWE:IFBW 100")
    number = bench.taken
    bench.driver._link.drop()
    bench.clock.sleep_until_s(bench.clock.now_s() + bench.values.link_check_s)
    bench.driver.check_idle_link()
    if not is_changed:
        assert bench.driver.confirm(number).remarks == ()
        return
    with raises_fault(VNA_SETTINGS):
        bench.driver.confirm(number)


# Links and instruments.


@each_case("when", [":INIT:IMM", ":STAT:OPER?", ":CALC1:DATA?", PREAMBLE])
def test_a_broken_link_is_replaced_and_the_settings_compared(when):
    bench = Bench().configured()
    bench.lose_link_once(when)
    assert bench.is_new()
    assert bench.links == 2 and bench.open_links == 1
    assert "*IDN?" in bench.sent and PREAMBLE in bench.sent
    # An instrument that kept its settings is not set up again: that may end its calibration.
    told = {one for one in bench.sent if "?" not in one}
    assert told == {CONNECT, LOCK, CLEAR, ":INIT:IMM"}
    assert bench.driver.state.repeats == 1 and not bench.driver.state.last_error


def test_another_serial_number_fails_the_request_at_once_until_it_is_connected(bench):
    bench.faults.set("OTHER_SERIAL")
    bench.lose_link_once()
    begun_s = bench.clock.now_s()
    with raises_fault(VNA_REPLACED, "SIMULATED-2"):
        bench.driver.get_trace()
    assert bench.clock.now_s() - begun_s < 3.0 and bench.open_links == 0
    assert "SIMULATED-2" in bench.driver.connect_to_vna(ADDRESS)
    assert bench.configured().is_new()


@each_case("says_its_serial_number", [True, False])
def test_another_instrument_on_the_same_link_is_noticed(says_its_serial_number):
    bench = Bench(unanswered_queries=() if says_its_serial_number else (PREAMBLE,))
    number = bench.configured().taken
    bench.faults.set("SWAPPED")
    with raises_fault(VNA_REPLACED, "SIMULATED-2", error=VnaReplacedError):
        bench.driver.confirm(number)
    with raises_fault(VNA_REPLACED, "SIMULATED-2"):
        bench.driver.take_sweep()


def test_connecting_again_and_disconnecting_close_the_link_and_forget_the_sweep(bench):
    bench.driver.connect_to_vna("192.168.1.11")
    assert bench.open_links == 1 and bench.driver.state.sweep is None
    bench.configured()
    bench.driver.disconnect_from_vna()
    assert bench.open_links == 0 and not bench.driver.state.linked
    # It sweeps by itself again, and is left alone.
    assert bench.vna.sweeper.runs_continuously and not bench.vna.instrument.is_remote
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


def test_exchanges_of_two_callers_do_not_mix(bench):
    found: List[bool] = []

    def measure() -> None:
        for _ in range(10):
            sweep = bench.driver.get_trace()
            found.append(len(set(sweep.s21_real)) == 1)

    threads = [threading.Thread(target=measure) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=30.0)
    assert found == [True] * 30
