"""The right instrument, set up as requested, or an error with the reason."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from driver_bench import ACCEPTED, ADDRESS, SWEEP, Bench
from fake_vna import IDENTITY
from fault_kit import raises_fault

from gpr20_common import faults as common_faults
from gpr20_common.message import Message
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import (
    VnaClosedError,
    VnaConnectionError,
    VnaIdentityError,
    VnaNotReadyError,
    VnaSweepError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.vna_driver import VNADriver


@pytest.fixture
def bench() -> Bench:
    return Bench().configured()


@pytest.mark.parametrize(
    "identity",
    ['"Anritsu,MS2038C/2,1,1"', '"Keysight,MS2026C/2,1,1"', "", "garbage", '"Anritsu,MS2026C/2"'],
)
def test_another_instrument_is_refused_and_its_link_closed(identity):
    bench = Bench()
    bench.vna.identity = identity
    with raises_fault(faults.WRONG_INSTRUMENT, "Anritsu MS2026C"):
        bench.driver.connect_to_vna(ADDRESS)
    assert bench.vna.open_links == 0 and not bench.driver.vna_connected


def test_an_unreadable_identification_is_in_the_details_not_in_the_sentence():
    bench = Bench()
    bench.vna.identity = "P\x006\x07"
    with raises_fault(faults.WRONG_INSTRUMENT, "'P?6?'") as refusal:
        bench.driver.connect_to_vna(ADDRESS)
    assert refusal.value.message.details == repr("P\x006\x07")


def test_the_reports_say_why_no_connection_was_made_until_there_is_one():
    bench = Bench()
    expected, bench.vna.identity = bench.vna.identity, "garbage"
    with pytest.raises(VnaIdentityError):
        bench.driver.connect_to_vna(ADDRESS)
    assert bench.driver.state.last_error.fault == faults.WRONG_INSTRUMENT
    bench.vna.identity = expected
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.driver.state.last_error is None


def test_expected_model_is_a_parameter():
    bench = Bench(model="MS2038C")
    bench.vna.identity = "Anritsu,MS2038C/11,2032023,3.90"
    assert bench.driver.connect_to_vna(ADDRESS).startswith("Anritsu,MS2038C")


def test_an_address_that_is_not_four_numbers_is_refused():
    bench = Bench()
    for address in ("", "192.168.1", "192.168.1.256", "localhost", "1.2.3.4.5"):
        with raises_fault(common_faults.NOT_ALLOWED, f"'{address}'"):
            bench.driver.connect_to_vna(address)
    assert bench.vna.links == 0


@pytest.mark.parametrize(
    "call", ["get_trace", "get_freq", "check_calibration_status", "test_connection"]
)
def test_without_connection_the_caller_is_told_to_connect(call):
    with raises_fault(faults.NOT_CONNECTED, "service connection"):
        getattr(Bench().driver, call)()


@pytest.mark.parametrize("call", ["get_trace", "get_freq"])
def test_without_configuration_the_caller_is_told_to_configure(call):
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    with raises_fault(faults.NOT_CONFIGURED, "freq_sweep_setup"):
        getattr(bench.driver, call)()


def test_configuring_holds_the_instrument_and_confirms_everything(bench):
    assert bench.vna.settings == {
        ":INIT:CONT": "0",
        ":SENS:FREQ:STAR": "600000000",
        ":SENS:FREQ:STOP": "6000000000",
        ":SENS:SWE:POIN": "11",
        ":SENS:TRAC:TOT": "1",
        ":SENS:TRACE1:SPAR": "S21",
        ":SENS:TRACE1:DOM": "FREQ",
        ":SENS:AVER:COUN": "1",
        ":SENS:SWE:IFBW": "10000",
        ":SOUR:POW": "HIGH",
        ":FORM": "REAL,32",
    }
    assert all(f"{header}?" in bench.vna.sent for header in bench.vna.settings)
    assert bench.driver.state.sweep == ACCEPTED
    assert bench.driver.get_freq().tolist() == np.linspace(600e6, 6e9, 11).tolist()


def test_an_instrument_without_time_domain_is_not_asked_for_it():
    bench = Bench()
    bench.vna.identity = "Anritsu,MS2026C,1234567,1.23"
    del bench.vna.settings[":SENS:TRACE1:DOM"]
    bench.configured()
    assert not [message for message in bench.vna.sent if ":DOM" in message]


def test_a_setting_may_take_the_instruments_settling_time():
    bench = Bench()
    bench.vna.settling_s = 1.9
    bench.configured()
    assert bench.driver.state.sweep == ACCEPTED


@pytest.mark.parametrize("header", [":SENS:FREQ:STAR", ":FORM", ":INIT:CONT"])
def test_a_refused_setting_is_named_and_nothing_is_measured_with_the_former_one(header):
    bench = Bench()
    bench.vna.refused = [header]
    with raises_fault(faults.SETTING_REFUSED, header):
        bench.configured()
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


def test_a_failed_setup_forgets_the_former_one(bench):
    bench.vna.refused = [":SENS:SWE:POIN"]
    with raises_fault(faults.SETTING_REFUSED, "'11'", 21):
        bench.driver.set_frequency_sweep(SweepSettings(600e6, 6e9, 21))
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


def test_an_instrument_that_measures_other_frequencies_is_refused():
    bench = Bench()
    bench.vna._frequencies = lambda: list(np.geomspace(600e6, 6e9, 11))
    with raises_fault(faults.NOT_LINEAR):
        bench.configured()


def test_calibration_is_read_by_its_meaning(bench):
    for status in list(CalibrationStatus)[: CalibrationStatus.NOT_REPORTED]:
        bench.vna.calibration = str(int(status))
        assert bench.driver.check_calibration_status() is status
        assert bench.driver.state.calibration is status


def test_a_calibration_off_the_scale_is_an_error(bench):
    for bench.vna.calibration in ("5", "-1", "1.5", "", "nan", "high", "0_1"):
        with raises_fault(faults.BAD_DATA, 9, error=VnaSweepError):
            print(bench.vna.calibration, bench.driver.check_calibration_status())


def test_disconnecting_closes_the_link_and_forgets_the_sweep(bench):
    bench.driver.disconnect_from_vna()
    assert bench.vna.open_links == 0 and not bench.driver.state.linked
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


@pytest.mark.parametrize("same_one", [True, False])
def test_disconnecting_after_a_lost_link_leaves_the_instrument_sweeping(bench, same_one):
    def lose_link(_message: str) -> None:
        bench.vna.before = lambda _message: None
        raise VnaConnectionError(Message("broken on purpose"))

    bench.vna.before = lose_link
    with pytest.raises(VnaConnectionError):
        bench.driver.test_connection()
    if not same_one:
        bench.vna.identity = IDENTITY.replace("1234567", "7654321")
    bench.driver.disconnect_from_vna()
    assert bench.vna.local is same_one, "another instrument is left alone"
    assert bench.vna.answer(":INIT:CONT?") == (b"1" if same_one else b"0")
    assert bench.vna.open_links == 0


def test_connecting_again_closes_the_former_link(bench):
    bench.driver.connect_to_vna("192.168.1.11")
    assert bench.vna.open_links == 1
    assert bench.driver.state.sweep is None


@pytest.mark.parametrize(
    "request_after",
    [VNADriver.disconnect_from_vna, lambda driver: driver.connect_to_vna(ADDRESS)],
)
def test_a_sweep_that_nobody_waits_for_any_more_ends_at_once(bench, request_after):
    bench.vna.sweep_s = 1e9
    threads = []

    def request_while_waiting(message: str) -> None:
        if message == ":STAT:OPER?" and not threads:
            threads.append(threading.Thread(target=request_after, args=[bench.driver]))
            threads[0].start()
            with pytest.raises(VnaTimeoutError):
                while True:
                    bench.deadline.check()

    bench.vna.before = request_while_waiting
    begun_s = bench.clock.now_s()
    with raises_fault(faults.SUPERSEDED):
        bench.driver.get_trace()
    threads[0].join(10.0)
    assert bench.clock.now_s() - begun_s < 5.0
    bench.driver.connect_to_vna(ADDRESS)
    bench.vna.sweep_s = 0.05
    bench.driver.set_frequency_sweep(SWEEP)
    bench.driver.get_trace()


def test_a_shutdown_ends_a_waiting_sweep_and_later_calls(bench):
    bench.vna.sweep_s = 1e9

    def shut_down_while_waiting(message: str) -> None:
        if message == ":STAT:OPER?":
            bench.driver.shut_down()

    bench.vna.before = shut_down_while_waiting
    with pytest.raises(VnaClosedError):
        bench.driver.get_trace()
    assert bench.vna.open_links == 0
    with pytest.raises(VnaClosedError):
        bench.driver.connect_to_vna(ADDRESS)


def test_a_start_above_the_former_stop_is_set_once_the_new_stop_is_there(bench):
    bench.vna.keeps_order = True
    bench.driver.set_frequency_sweep(SweepSettings(600e6, 1e9, 11))
    higher = SweepSettings(3e9, 6e9, 11)
    assert bench.driver.set_frequency_sweep(higher).fulfils(higher)


def test_setting_up_ends_within_the_time_limit_of_one_request():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    begun_s, step_s = bench.clock.now_s(), 2.4
    bench.vna.before = lambda message: bench.clock.pass_s(step_s)
    with raises_fault(faults.TOO_SLOW, 40, error=VnaTimeoutError):
        bench.driver.set_frequency_sweep(SWEEP)
    assert bench.clock.now_s() - begun_s < 40.0 + 2.0 * step_s


def test_nothing_is_asked_before_the_buffers_are_emptied():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.vna.sent[:3] == ["<lock>", "<clear>", "*IDN?"]


def test_no_calibration_is_not_the_best_one():
    assert CalibrationStatus.NONE == 0 and CalibrationStatus.HIGH == 1
