"""An idle instrument is monitored: a pulled cable is reported, and its return."""

from __future__ import annotations

import threading

import pytest
from driver_bench import ADDRESS, SWEEP, Bench

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaError, VnaNotReadyError

CHECK_S = 5.0
NO_ANSWER = Message("no answer")


@pytest.fixture
def bench() -> Bench:
    bench = Bench(link_check_s=CHECK_S).configured()
    bench.vna.sent.clear()
    return bench


def cable_is_pulled(message: str) -> None:
    raise VnaConnectionError(NO_ANSWER)


def check_after(bench: Bench, idle_s: float) -> None:
    bench.clock.pass_s(idle_s)
    bench.driver.check_idle_link()


def test_an_instrument_in_use_is_not_disturbed(bench):
    bench.driver.get_trace()
    bench.vna.sent.clear()
    check_after(bench, CHECK_S - 1.0)
    assert bench.vna.sent == []


def test_an_address_that_nothing_can_have_does_not_end_the_checks(bench):
    with pytest.raises(InvalidValueError):
        bench.driver.connect_to_vna("x\ny")
    assert not bench.driver.vna_ip
    check_after(bench, CHECK_S)
    assert bench.driver.connect_to_vna(ADDRESS)
    bench.vna.sent.clear()
    check_after(bench, CHECK_S)
    assert bench.vna.sent == [":SENS:CORR:COLL:STAT:ACC?"]


def test_an_idle_instrument_is_asked_for_its_calibration_once_in_a_while(bench):
    bench.vna.calibration = "4"
    check_after(bench, CHECK_S)
    bench.driver.check_idle_link()
    assert bench.vna.sent == [":SENS:CORR:COLL:STAT:ACC?"]
    assert bench.driver.state.calibration is CalibrationStatus.LOW


def test_a_pulled_cable_is_reported_until_it_is_back_and_the_sweep_is_set_up_again(bench):
    bench.vna.before = cable_is_pulled
    check_after(bench, CHECK_S)
    assert bench.driver.state.link_error == NO_ANSWER
    assert not bench.driver.state.linked and bench.vna.open_links == 0
    check_after(bench, CHECK_S)
    assert bench.driver.state.link_error == NO_ANSWER
    bench.vna.before = lambda message: None
    bench.vna.settings[":SENS:SWE:POIN"] = "201"  # it was switched off and on
    check_after(bench, CHECK_S)
    assert bench.driver.state.link_error is None and bench.driver.state.linked
    # Nothing is written before the next sweep: somebody may be calibrating it.
    assert bench.vna.settings[":SENS:SWE:POIN"] == "201"
    assert (bench.driver.get_trace().frequency_hz == SWEEP.frequencies_hz()).all()
    assert bench.vna.settings[":SENS:SWE:POIN"] == str(SWEEP.points)


def test_an_address_where_connecting_failed_is_tried_again_until_it_answers(bench):
    bench.vna.before = cable_is_pulled
    with pytest.raises(VnaConnectionError):
        bench.driver.connect_to_vna(ADDRESS)
    check_after(bench, CHECK_S)
    assert bench.driver.state.trouble == NO_ANSWER and bench.vna.open_links == 0
    bench.vna.before = lambda message: None
    check_after(bench, CHECK_S)
    assert bench.driver.state.trouble is None and bench.driver.state.linked
    assert bench.driver.state.address == ADDRESS
    assert bench.driver.state.calibration is CalibrationStatus.HIGH
    # Only the survey knows what to sweep.
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


def test_what_was_wrong_is_reported_until_connecting_again_has_ended(bench):
    bench.vna.before = cable_is_pulled
    check_after(bench, CHECK_S)
    reported = []
    bench.vna.before = lambda message: reported.append(bench.driver.state.trouble)
    bench.driver.connect_to_vna(ADDRESS)
    assert set(reported) == {NO_ANSWER} and bench.driver.state.trouble is None


def test_a_request_that_succeeds_ends_the_error_of_the_check(bench):
    bench.vna.before = cable_is_pulled
    check_after(bench, CHECK_S)
    bench.vna.before = lambda message: None
    bench.driver.get_trace()
    assert bench.driver.state.link_error is None


def garbled(bench: Bench) -> None:
    bench.vna.spoil = lambda answer: b"#9"


def silent(bench: Bench) -> None:
    bench.vna.before = cable_is_pulled


@pytest.mark.parametrize("fail", [garbled, silent])
def test_the_fault_of_a_request_ends_when_the_instrument_answers_again(bench, fail):
    fail(bench)
    with pytest.raises(VnaError):
        bench.driver.get_trace()
    reported = bench.driver.state.last_error
    assert reported and bench.driver.trouble == reported
    bench.vna.spoil, bench.vna.before = lambda answer: answer, lambda message: None
    check_after(bench, CHECK_S)
    assert bench.driver.trouble is None
    # It is still known until data prove the opposite.
    assert bench.driver.state.former_trouble == reported
    bench.driver.get_trace()
    assert bench.driver.state.former_trouble is None


def test_a_fault_after_the_instrument_has_answered_is_a_fault_of_now(bench):
    garbled(bench)
    with pytest.raises(VnaError):
        bench.driver.get_trace()
    check_after(bench, CHECK_S)
    with pytest.raises(VnaError):
        bench.driver.get_trace()
    assert bench.driver.trouble is not None
    check_after(bench, CHECK_S)
    bench.vna.before = cable_is_pulled
    check_after(bench, CHECK_S)
    assert bench.driver.trouble == NO_ANSWER and bench.driver.state.former_trouble is None


@pytest.mark.parametrize("end", ["disconnect_from_vna", "shut_down"])
def test_an_address_where_connecting_failed_is_left_alone_after_the_end(bench, end):
    bench.vna.before = cable_is_pulled
    with pytest.raises(VnaConnectionError):
        bench.driver.connect_to_vna(ADDRESS)
    getattr(bench.driver, end)()
    bench.vna.before = lambda message: None
    links = bench.vna.links
    check_after(bench, CHECK_S)
    assert bench.vna.links == links and bench.driver.state.trouble is None


@pytest.mark.parametrize("end", ["disconnect_from_vna", "shut_down"])
def test_nothing_is_connected_again_after_the_end(bench, end):
    getattr(bench.driver, end)()
    bench.vna.sent.clear()
    check_after(bench, CHECK_S)
    assert bench.vna.sent == [] and bench.vna.open_links == 0
    assert bench.driver.state.link_error is None and not bench.driver.state.linked


def test_the_check_does_not_wait_for_a_request_that_runs(bench):
    checked = threading.Event()

    def check_meanwhile(message: str) -> None:
        if message == "*IDN?":
            bench.clock.pass_s(CHECK_S)
            thread = threading.Thread(target=bench.driver.check_idle_link)
            thread.start()
            thread.join(10.0)
            if not thread.is_alive():
                checked.set()

    bench.vna.before = check_meanwhile
    bench.driver.connect_to_vna(ADDRESS)
    assert checked.is_set()
