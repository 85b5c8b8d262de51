"""Every request is answered in the time that its caller knows, and confirms only its sweep."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Callable

import pytest
from driver_bench import ADDRESS, SWEEP, Bench
from fault_kit import raises_fault

from gpr20_common.message import Message
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import (
    VnaConnectionError,
    VnaError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.vna_driver import VNADriver


def test_a_sweep_that_never_ends_is_answered_within_the_promised_time():
    bench = Bench().configured()
    bench.vna.sweep_s = 1e6
    begun_s, limit_s = bench.clock.time_s, bench.driver.answered_within_s
    with pytest.raises(VnaError):
        bench.driver.take_sweep()
    assert bench.clock.time_s - begun_s <= limit_s


def test_the_promised_time_stays_when_sweeps_become_slower():
    bench = Bench().configured()
    limit_s = bench.driver.answered_within_s
    bench.vna.sweep_s = 3.0
    for _ in range(9):
        bench.driver.take_sweep()
    assert bench.driver.trace_duration_s >= 3.0
    bench.vna.before = lambda message: bench.clock.pass_s(2.0)
    bench.vna.spoil = lambda answer: answer[:-9]
    begun_s = bench.clock.time_s
    with pytest.raises(VnaTimeoutError):
        bench.driver.take_sweep()
    assert bench.clock.time_s - begun_s <= limit_s == bench.driver.answered_within_s


def test_a_setup_of_sweeps_that_never_end_has_one_time_limit():
    bench = Bench()
    bench.vna.sweep_s = 1e6
    bench.driver.connect_to_vna(ADDRESS)
    begun_s = bench.clock.time_s
    with raises_fault(faults.SWEEP_NOT_ENDED, 10, error=VnaTimeoutError):
        bench.driver.set_frequency_sweep(SWEEP)
    # Of which 20 s are to learn how long a sweep takes; main control waits for 90 s.
    assert bench.clock.time_s - begun_s <= 70.0


def test_the_wait_for_another_request_counts():
    bench = Bench().configured()
    limit_s = bench.driver.answered_within_s
    waits, waited = threading.Event(), []

    def wait_for_the_check() -> None:
        begun_s = bench.clock.time_s
        waits.set()
        with pytest.raises(VnaTimeoutError):
            bench.driver.take_sweep()
        waited.append(bench.clock.time_s - begun_s)

    thread = threading.Thread(target=wait_for_the_check)

    def hang(message: str) -> None:
        if not thread.ident:
            thread.start()
            assert waits.wait(10.0)
            thread.join(0.2)
            bench.clock.pass_s(30.0)
        bench.clock.pass_s(6.0)
        raise VnaConnectionError(Message("hangs"))

    bench.vna.before = hang
    with pytest.raises(VnaConnectionError):
        bench.driver.test_connection()
    thread.join(10.0)
    assert waited and waited[0] <= limit_s


@pytest.mark.parametrize("lost_for_s", [28.0, 38.9])
def test_connecting_slowly_at_each_step_is_within_the_promised_time(lost_for_s):
    bench = Bench().configured()
    begun_s, limit_s = bench.clock.time_s, bench.driver.answered_within_s
    connect_s = bench.driver.parameters.connect_timeout_s

    def connect(_address: str) -> None:
        # At first refused; then portmapper, core channel and link, each just not in time.
        refused = bench.clock.time_s - begun_s < lost_for_s
        bench.clock.pass_s(0.0 if refused else 3.0 * connect_s + 1.0 + 0.5)
        raise VnaConnectionError(Message("no answer in time"))

    bench.analyzer.connect = connect
    bench.driver._link.drop()
    with pytest.raises(VnaTimeoutError):
        bench.driver.take_sweep()
    assert bench.clock.time_s - begun_s <= limit_s


@pytest.mark.parametrize(
    "meanwhile",
    [
        lambda driver: driver.set_frequency_sweep(replace(SWEEP, points=21)),
        lambda driver: driver.set_frequency_sweep(SWEEP),
        lambda driver: driver.connect_to_vna(ADDRESS),
    ],
    ids=["other settings", "the same settings", "connection"],
)
def test_a_sweep_is_not_confirmed_after_another_setup(meanwhile: Callable[[VNADriver], None]):
    bench = Bench().configured()
    number, _sweep = bench.driver.take_sweep()
    meanwhile(bench.driver)
    with raises_fault(faults.SWEEP_UNCONFIRMED, number):
        bench.driver.confirm(number)


@pytest.mark.parametrize(
    "meanwhile",
    [VNADriver.check_calibration_status, VNADriver.get_trace],
)
def test_a_change_by_hand_is_not_hidden_by_a_request_before_the_confirmation(meanwhile):
    bench = Bench().configured()
    bench.vna.settings[":SENS:SWE:IFBW"] = "100"
    number, _sweep = bench.driver.take_sweep()
    bench.driver._link.drop()
    meanwhile(bench.driver)
    assert bench.vna.settings[":SENS:SWE:IFBW"] == "10000"
    with raises_fault(faults.SWEEP_UNCONFIRMED, number):
        bench.driver.confirm(number)


def test_a_change_by_hand_is_still_seen_after_the_check_of_an_idle_link():
    bench = Bench().configured()
    bench.vna.settings[":SENS:SWE:IFBW"] = "100"
    number, _sweep = bench.driver.take_sweep()
    bench.driver._link.drop()
    bench.driver.test_connection()
    with raises_fault(faults.SETTINGS_CHANGED):
        bench.driver.confirm(number)


def test_a_request_that_changes_nothing_does_not_hinder_the_confirmation():
    bench = Bench().configured()
    number, _sweep = bench.driver.take_sweep()
    bench.driver._link.drop()
    bench.driver.test_connection()
    assert bench.driver.confirm(number).remarks == ()
