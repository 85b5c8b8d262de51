"""The right instrument, set up as requested, or an error with the reason."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from case_kit import each_case
from driver_bench import ACCEPTED, ADDRESS, IDENTITY, Bench
from fault_kit import raises_fault

from gpr20_common import faults as common_faults
from gpr20_common.faults import BUSY
from gpr20_survey.faults import NOT_CALIBRATED, VNA_FAILED, VNA_SETTINGS, WRONG_VNA
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import (
    VnaClosedError,
    VnaConnectionError,
    VnaNotReadyError,
    VnaSweepError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.vna_driver import VNADriver


@pytest.fixture
def bench() -> Bench:
    return Bench().configured()


@each_case(
    "identity",
    [
        '"Anritsu,MS2038C/2,1,1"',
        "P\x006\x07",
        '"Anritsu,MS2026C/2"',
    ],
)
def test_another_instrument_is_refused_and_its_link_closed(identity):
    bench = Bench()
    bench.vna.identity = identity
    with raises_fault(WRONG_VNA, "Anritsu MS2026C") as refusal:
        bench.driver.connect_to_vna(ADDRESS)
    assert bench.vna.open_links == 0 and not bench.driver.state.linked
    assert bench.driver.state.last_error.fault == WRONG_VNA
    if "\x07" in identity:
        assert "'P?6?'" in str(refusal.value)
        assert refusal.value.message.details == repr(identity)
    bench.vna.identity = IDENTITY
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.driver.state.last_error is None


@each_case("address", ["", "192.168.1.256", "localhost"])
def test_an_address_that_is_not_four_numbers_is_refused(address):
    bench = Bench()
    with raises_fault(common_faults.NOT_ALLOWED, f"'{address}'"):
        bench.driver.connect_to_vna(address)
    assert bench.vna.links == 0 and not bench.driver.state.address


@each_case(
    "call, connected, fault, shown",
    [
        ("get_trace", False, faults.NOT_CONNECTED, "service connection"),
        ("check_calibration_status", False, faults.NOT_CONNECTED, "service connection"),
        ("get_freq", True, faults.NOT_CONNECTED, "freq_sweep_setup"),
    ],
)
def test_the_caller_is_told_to_connect_or_to_configure_first(call, connected, fault, shown):
    bench = Bench()
    if connected:
        bench.driver.connect_to_vna(ADDRESS)
    with raises_fault(fault, shown):
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


@pytest.mark.parametrize("header", [":SENS:FREQ:STAR", ":FORM", ":INIT:CONT"])
def test_a_refused_setting_is_named_and_nothing_is_measured_with_the_former_one(header):
    bench = Bench()
    bench.vna.refused = [header]
    with raises_fault(VNA_SETTINGS, header):
        bench.configured()
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


def test_a_failed_setup_forgets_the_former_one(bench):
    bench.vna.refused = [":SENS:SWE:POIN"]
    with raises_fault(VNA_SETTINGS, "'11'", 21):
        bench.driver.set_frequency_sweep(SweepSettings(600e6, 6e9, 21))
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


def test_calibration_is_read_by_its_meaning(bench):
    for status in list(CalibrationStatus)[: CalibrationStatus.NOT_REPORTED]:
        bench.vna.calibration = str(int(status))
        assert bench.driver.check_calibration_status() is status
        assert bench.driver.state.calibration is status
    for bench.vna.calibration in ("5", "-1", "1.5", "", "nan", "high", "0_1"):
        with raises_fault(VNA_FAILED, 9, error=VnaSweepError):
            print(bench.vna.calibration, bench.driver.check_calibration_status())


def test_a_calibration_without_s21_is_none():
    bench = Bench()
    bench.vna.calibrated = "1"
    bench.driver.connect_to_vna(ADDRESS)
    status = bench.driver.check_calibration_status()
    assert status is CalibrationStatus.NONE
    refusal = bench.driver.calibration_refusal(status)
    assert refusal.fault == NOT_CALIBRATED and "S11" in str(refusal)
    bench.vna.calibrated = "5"
    assert bench.driver.check_calibration_status() is CalibrationStatus.HIGH


def test_a_calibration_is_described_as_far_as_the_instrument_says():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    bench.driver.check_calibration_status()
    asked = {"parameters": ["S11", "S12", "S21", "S22"], "type": "2PFP", "interpolated": False}
    told = {"is_corrected": True, "temperature_c": 40.75, "smoothing_percent": 0, "trace_math": 0}
    assert bench.driver.state.calibration_details == {**asked, **told}
    bench.vna.unanswered = [":SENS:CAL:STAT?", ":SENS:CORR:COLL:TYPE?", ":SENS:CORR:COLL:INT?"]
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.driver.check_calibration_status() is CalibrationStatus.HIGH
    assert bench.driver.state.calibration_details == told


def test_connecting_again_and_disconnecting_close_the_link_and_forget_the_sweep(bench):
    bench.driver.connect_to_vna("192.168.1.11")
    assert bench.vna.open_links == 1 and bench.driver.state.sweep is None
    bench.configured()
    del bench.vna.sent[:]
    bench.driver.disconnect_from_vna()
    assert bench.vna.open_links == 0 and not bench.driver.state.linked
    # It sweeps by itself again, and is left alone.
    assert ":INIT:CONT ON" in bench.vna.sent and bench.vna.local
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


@pytest.mark.parametrize("same_one", [True, False])
def test_disconnecting_after_a_lost_link_leaves_the_instrument_sweeping(bench, same_one):
    bench.lose_link_once()
    with pytest.raises(VnaConnectionError):
        bench.driver.test_connection()
    if not same_one:
        bench.vna.identity = IDENTITY.replace("1234567", "7654321")
    bench.driver.disconnect_from_vna()
    assert bench.vna.local is same_one, "another instrument is left alone"
    assert bench.vna.answer(":INIT:CONT?") == (b"1" if same_one else b"0")
    assert bench.vna.open_links == 0


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
    with raises_fault(BUSY):
        bench.driver.get_trace()
    threads[0].join(30.0)
    assert bench.clock.now_s() - begun_s < 5.0
    bench.vna.sweep_s = 0.05
    bench.configured().driver.get_trace()


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


def test_nothing_is_asked_before_the_buffers_are_emptied():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.vna.sent[:3] == ["<lock>", "<clear>", "*IDN?"]
