"""An idle instrument is monitored, and every request is answered in the time its caller knows."""

from __future__ import annotations

import threading

import pytest
from case_kit import each_case
from driver_bench import ADDRESS, SWEEP, Bench
from fault_kit import raises_fault

from gpr20_common.message import Message
from gpr20_survey.faults import VNA_FAILED, VNA_SETTINGS, VNA_SILENT
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_vna_acquisition.errors import (
    VnaConnectionError,
    VnaError,
    VnaNotReadyError,
    VnaTimeoutError,
)

CHECK_S = 5.0
NO_ANSWER = Message("no answer")


@pytest.fixture
def bench() -> Bench:
    bench = Bench(link_check_s=CHECK_S).configured()
    bench.vna.sent.clear()
    return bench


def cable_is_pulled(message: str) -> None:
    raise VnaConnectionError(NO_ANSWER)


def nothing(message: str) -> None:
    """Let the instrument answer."""


def check_after(bench: Bench, idle_s: float = CHECK_S) -> None:
    bench.clock.pass_s(idle_s)
    bench.driver.check_idle_link()


def test_an_idle_instrument_is_asked_for_its_calibration_once_in_a_while(bench):
    bench.vna.calibration = "4"
    # One in use is not disturbed.
    check_after(bench, CHECK_S - 1.0)
    assert bench.vna.sent == []
    check_after(bench, 1.1)
    bench.driver.check_idle_link()
    assert bench.vna.sent == [":SENS:CORR:COLL:STAT:ACC?"]
    assert bench.driver.state.calibration is CalibrationStatus.LOW


def test_a_pulled_cable_is_reported_until_it_is_back_and_the_sweep_is_set_up_again(bench):
    bench.vna.before = cable_is_pulled
    for _ in range(2):
        check_after(bench)
        assert bench.driver.state.last_error == NO_ANSWER
        assert not bench.driver.state.linked and bench.vna.open_links == 0
    bench.vna.before = nothing
    bench.vna.settings[":SENS:SWE:POIN"] = "201"  # it was switched off and on
    check_after(bench)
    assert bench.driver.state.last_error is None and bench.driver.state.linked
    # Nothing is written before the next sweep: somebody may be calibrating it.
    assert bench.vna.settings[":SENS:SWE:POIN"] == "201"
    assert (bench.driver.get_trace().frequency_hz == SWEEP.frequencies_hz()).all()
    assert bench.vna.settings[":SENS:SWE:POIN"] == str(SWEEP.points)


def test_an_address_where_connecting_failed_is_tried_again_until_it_answers(bench):
    bench.vna.before = cable_is_pulled
    with pytest.raises(VnaConnectionError):
        bench.driver.connect_to_vna(ADDRESS)
    check_after(bench)
    assert bench.driver.state.last_error == NO_ANSWER and bench.vna.open_links == 0
    bench.vna.before = nothing
    check_after(bench)
    assert bench.driver.state.last_error is None and bench.driver.state.linked
    assert bench.driver.state.address == ADDRESS
    assert bench.driver.state.calibration is CalibrationStatus.HIGH
    # Only the survey knows what to sweep.
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


def test_the_fault_of_a_request_ends_when_the_instrument_answers_again(bench):
    bench.vna.spoil = lambda answer: b"#9"
    with pytest.raises(VnaError):
        bench.driver.get_trace()
    reported = bench.driver.state.last_error
    assert reported and bench.driver.trouble == reported
    bench.vna.before = nothing
    check_after(bench)
    assert bench.driver.trouble is None
    bench.vna.before = cable_is_pulled
    check_after(bench)
    assert bench.driver.trouble == NO_ANSWER
    bench.vna.spoil, bench.vna.before = lambda answer: answer, nothing
    bench.driver.get_trace()
    assert bench.driver.trouble is None


@each_case("end", ["disconnect_from_vna", "shut_down"])
def test_nothing_is_connected_again_after_the_end(end):
    bench = Bench(link_check_s=CHECK_S).configured()
    bench.vna.before = cable_is_pulled
    with pytest.raises(VnaConnectionError):
        bench.driver.connect_to_vna(ADDRESS)
    getattr(bench.driver, end)()
    bench.vna.before = nothing
    bench.vna.sent.clear()
    check_after(bench, 60.0)
    assert bench.vna.sent == [] and bench.vna.open_links == 0
    assert bench.driver.state.last_error is None and not bench.driver.state.linked


# The time limit of a request.


def slow_steps(bench: Bench) -> None:
    bench.vna.before = lambda message: bench.clock.pass_s(0.4)
    bench.vna.spoil = lambda answer: answer[:-9]


def endless_sweep(bench: Bench) -> None:
    bench.vna.sweep_s = 1e9


@each_case(
    "fail, parameters, fault, limit_s",
    [
        (endless_sweep, {}, VNA_SETTINGS, None),
        # The last attempt's fault says what to do, not that the time was over.
        (slow_steps, {"request_timeout_s": 20.0, "attempts": 50}, VNA_FAILED, 21.0),
    ],
)
def test_an_instrument_that_takes_too_long_is_given_up_in_time(fail, parameters, fault, limit_s):
    bench = Bench(**parameters).configured()
    limit_s = limit_s or bench.driver.answered_within_s
    fail(bench)
    begun_s = bench.clock.time_s
    with raises_fault(fault):
        bench.driver.take_sweep()
    assert bench.clock.time_s - begun_s <= limit_s
    assert bench.vna.open_links == 0
    bench.vna.before, bench.vna.spoil, bench.vna.sweep_s = nothing, lambda answer: answer, 0.05
    assert len(set(bench.driver.get_trace().s21_real)) == 1


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


def test_a_setup_has_one_time_limit():
    bench = Bench()
    bench.vna.sweep_s = 1e6
    bench.driver.connect_to_vna(ADDRESS)
    begun_s = bench.clock.time_s
    with raises_fault(VNA_SETTINGS, 10, error=VnaTimeoutError):
        bench.driver.set_frequency_sweep(SWEEP)
    # Of which 20 s are to learn how long a sweep takes; main control waits for 90 s.
    assert bench.clock.time_s - begun_s <= 70.0
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    begun_s, step_s = bench.clock.time_s, 2.4
    bench.vna.before = lambda message: bench.clock.pass_s(step_s)
    with raises_fault(VNA_SILENT, 40, error=VnaTimeoutError):
        bench.driver.set_frequency_sweep(SWEEP)
    assert bench.clock.time_s - begun_s < 40.0 + 2.0 * step_s


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
            assert waits.wait(30.0)
            thread.join(0.2)
            bench.clock.pass_s(30.0)
        bench.clock.pass_s(6.0)
        raise VnaConnectionError(Message("hangs"))

    bench.vna.before = hang
    with pytest.raises(VnaConnectionError):
        bench.driver.test_connection()
    thread.join(30.0)
    assert waited and waited[0] <= limit_s


@each_case("outage_s, survives", [(30.0, True), (60.0, False)])
def test_a_link_may_be_lost_for_half_a_minute(outage_s, survives):
    bench = Bench().configured()
    back_s = bench.clock.time_s + outage_s

    def gone(_message: str) -> None:
        if bench.clock.time_s < back_s:
            raise VnaConnectionError(Message("connection refused"))

    bench.vna.before = gone
    if survives:
        bench.driver.get_trace()
        assert bench.clock.time_s - back_s < 2.0
        assert len(bench.warnings) == 1
        return
    with raises_fault(VNA_SILENT, error=VnaTimeoutError):
        bench.driver.get_trace()


@each_case("lost_for_s", [28.0, 38.9])
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
