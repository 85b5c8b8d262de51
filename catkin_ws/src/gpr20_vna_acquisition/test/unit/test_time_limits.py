"""An idle instrument is monitored, and every request is answered in the time its caller knows."""

from __future__ import annotations

import threading

import pytest
from case_kit import each_case
from driver_bench import ADDRESS, STATUS, SWEEP, Bench, nothing
from fault_kit import raises_fault

from gpr20_common.faults import BUSY
from gpr20_common.message import Message
from gpr20_survey.faults import VNA_FAILED, VNA_SETTINGS, VNA_SILENT
from gpr20_vna_acquisition.errors import (
    VnaClosedError,
    VnaConnectionError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.vna_driver import VNADriver

CHECK_S = 5.0


@pytest.fixture
def bench() -> Bench:
    return Bench(link_check_s=CHECK_S).configured()


def pass_s(bench: Bench, duration_s: float) -> None:
    bench.clock.sleep_until_s(bench.clock.now_s() + duration_s)


def check_after(bench: Bench, idle_s: float = CHECK_S) -> None:
    pass_s(bench, idle_s)
    bench.driver.check_idle_link()


# An idle link.


# The end of a request.


@pytest.mark.parametrize(
    "request_after",
    [VNADriver.disconnect_from_vna, lambda driver: driver.connect_to_vna(ADDRESS)],
)
def test_a_sweep_that_nobody_waits_for_any_more_ends_at_once(bench, request_after):
    bench.takes(1e6)
    threads = []

    def request_while_waiting(message: str) -> None:
        if message == STATUS and not threads:
            threads.append(threading.Thread(target=request_after, args=[bench.driver]))
            threads[0].start()
            with pytest.raises(VnaTimeoutError):
                while True:
                    bench.deadline.check()

    bench.before = request_while_waiting
    begun_s = bench.clock.now_s()
    with raises_fault(BUSY):
        bench.driver.get_trace()
    threads[0].join(30.0)
    assert bench.clock.now_s() - begun_s < 5.0
    bench.faults.clear()
    assert bench.configured().is_new()


def test_a_shutdown_ends_a_waiting_sweep_and_later_calls(bench):
    bench.takes(1e6)
    bench.before = lambda message: bench.driver.shut_down() if message == STATUS else None
    with pytest.raises(VnaClosedError):
        bench.driver.get_trace()
    with pytest.raises(VnaClosedError):
        bench.driver.connect_to_vna(ADDRESS)
    del bench.sent[:]
    check_after(bench)
    assert bench.sent == [] and bench.open_links == 0


# The time limit of a request.


def slow_steps(bench: Bench) -> None:
    bench.before = lambda _message: pass_s(bench, 0.4)
    bench.faults.set("TRUNCATE")


def silent(bench: Bench) -> None:
    bench.faults.set("SILENT")


@each_case(
    "fail, parameters, fault, limit_s",
    [
        (lambda bench: bench.takes(1e6), {}, VNA_SETTINGS, None),
        (silent, {}, VNA_SILENT, None),
        # The last attempt's fault says what to do, not that the time was over.
        (slow_steps, {"request_timeout_s": 20.0, "attempts": 50}, VNA_FAILED, 21.0),
    ],
)
def test_an_instrument_that_takes_too_long_is_given_up_in_time(fail, parameters, fault, limit_s):
    bench = Bench(**parameters).configured()
    limit_s = limit_s or bench.driver.answered_within_s
    fail(bench)
    begun_s = bench.clock.now_s()
    with raises_fault(fault):
        bench.driver.take_sweep()
    assert bench.clock.now_s() - begun_s <= limit_s
    assert bench.open_links == 0
    bench.before = nothing
    bench.faults.clear()
    assert bench.is_new()


def test_a_set_up_has_one_time_limit():
    bench = Bench()
    bench.takes(1e6)
    bench.driver.connect_to_vna(ADDRESS)
    begun_s = bench.clock.now_s()
    with raises_fault(VNA_SETTINGS, 10, error=VnaTimeoutError):
        bench.driver.set_frequency_sweep(SWEEP)
    # Of which 20 s are to learn how long a sweep takes; main control waits for 90 s.
    assert bench.clock.now_s() - begun_s <= 70.0
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    begun_s, step_s = bench.clock.now_s(), 2.4
    bench.before = lambda _message: pass_s(bench, step_s)
    with raises_fault(VNA_SILENT, 40, error=VnaTimeoutError):
        bench.driver.set_frequency_sweep(SWEEP)
    assert bench.clock.now_s() - begun_s < 40.0 + 2.0 * step_s


def test_the_wait_for_another_request_counts(bench):
    limit_s = bench.driver.answered_within_s
    waits, waited = threading.Event(), []

    def wait_for_the_check() -> None:
        begun_s = bench.clock.now_s()
        waits.set()
        with pytest.raises(VnaTimeoutError):
            bench.driver.take_sweep()
        waited.append(bench.clock.now_s() - begun_s)

    thread = threading.Thread(target=wait_for_the_check)

    def hang(_message: str) -> None:
        if not thread.ident:
            thread.start()
            assert waits.wait(30.0)
            thread.join(0.2)
            pass_s(bench, 30.0)
        pass_s(bench, 6.0)
        raise VnaConnectionError(Message("hangs"))

    bench.before = hang
    check_after(bench)
    thread.join(30.0)
    assert waited and waited[0] <= limit_s
