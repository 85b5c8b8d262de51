"""The right instrument, set up as requested, or an error with the reason."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case
from driver_bench import ACCEPTED, ADDRESS, POINTS, SWEEP, TRIGGER, Bench, as_sent
from fault_kit import raises_fault

from gpr20_common import faults as common_faults
from gpr20_common.mid.codec import record_from
from gpr20_simulator.mid.analyzer.simulated_analyzer import CLEAR, CONNECT, LOCK
from gpr20_simulator.mid.world.scene import InstrumentScene
from gpr20_survey.faults import (
    NOT_CALIBRATED,
    VNA_DOUBTFUL,
    VNA_FAILED,
    VNA_SETTINGS,
    VNA_SILENT,
    WRONG_VNA,
)
from gpr20_survey.trace.sweep import AnalyzerSettings, CalibrationStatus, SweepSettings
from gpr20_vna_acquisition.errors import VnaNotReadyError, VnaSweepError
from gpr20_vna_acquisition.mid.ms2026c_commands import OPTIONAL, check_frequencies
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SET_UP = {
    ":INIT:CONT": "0",
    ":SENS:FREQ:STAR": "600000000",
    ":SENS:FREQ:STOP": "6000000000",
    ":SENS:SWE:POIN": str(POINTS),
    ":SENS:TRAC:TOT": "1",
    ":SENS:TRACE1:SPAR": "S21",
    ":SENS:TRACE1:DOM": "FREQ",
    ":SENS:AVER:COUN": "1",
    ":SENS:SWE:IFBW": "10000",
    ":SOUR:POW": "HIGH",
    ":FORM": "REAL,32",
}


@pytest.fixture
def bench() -> Bench:
    return Bench().configured()


# Connecting.


@each_case("identity", ['"Anritsu,MS2038C/2,1,1"', "P\x006\x07", '"Anritsu,MS2026C/2"'])
def test_another_instrument_is_refused_and_its_link_closed(identity):
    bench = Bench()
    bench.answers("*IDN?", identity.encode())
    with raises_fault(WRONG_VNA, "Anritsu MS2026C") as refusal:
        bench.driver.connect_to_vna(ADDRESS)
    assert bench.open_links == 0 and not bench.driver.state.linked
    assert bench.driver.trouble.fault == WRONG_VNA
    assert "\x07" not in str(refusal.value)
    bench.vna.on_answer = as_sent
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.driver.trouble is None


@each_case("address", ["", "192.168.1.256", "localhost"])
def test_an_address_that_is_not_four_numbers_is_refused(address):
    bench = Bench()
    with raises_fault(common_faults.NOT_ALLOWED, f"'{address}'"):
        bench.driver.connect_to_vna(address)
    assert bench.links == 0 and not bench.driver.state.address


def test_nothing_is_asked_before_the_buffers_are_emptied():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.sent == [CONNECT, LOCK, CLEAR, "*IDN?"]


# Settings.


def test_setting_up_holds_the_instrument_and_confirms_everything():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    accepted = bench.driver.set_frequency_sweep(SWEEP)
    assert {header: bench.ask(f"{header}?") for header in SET_UP} == SET_UP
    assert all(f"{header}?" in bench.sent for header in SET_UP)
    assert not [one for one in bench.sent if "RST" in one.upper()], "it resets the network"
    assert accepted == bench.driver.state.sweep == ACCEPTED
    assert bench.driver.get_freq().tolist() == np.linspace(600e6, 6e9, POINTS).tolist()
    # Only what differs is written again: writing may end the calibration.
    del bench.sent[:]
    bench.driver.set_frequency_sweep(SWEEP)
    assert bench.commands() == {TRIGGER}
    bench.by_hand(":SENS:TRACE1:SPAR S11")
    bench.driver.set_frequency_sweep(SWEEP)
    assert bench.commands() == {":SENS:TRACE1:SPAR S21", TRIGGER}


@each_case(
    "settings, header, value",
    [
        (AnalyzerSettings(20.0), ":SENS:SWE:IFBW", "20"),
        (AnalyzerSettings(output_power="LOW"), ":SOUR:POW", "LOW"),
    ],
)
def test_a_setting_of_the_survey_is_made_and_the_others_are_left(settings, header, value):
    bench = Bench()
    bench.by_hand(":SENS:SWE:IFBW 100", ":SOUR:POW LOW")
    bench.driver.connect_to_vna(ADDRESS)
    accepted = bench.driver.set_frequency_sweep(replace(SWEEP, analyzer=settings)).analyzer
    assert bench.ask(f"{header}?") == value and accepted.fulfils(settings)
    assert accepted == AnalyzerSettings(settings.if_bandwidth_hz or 100.0, 1, "LOW")
    assert bench.driver.get_trace().analyzer == accepted


def test_a_setting_may_take_a_while_until_it_can_be_read_back():
    assert Bench(InstrumentScene(setting_delay_s=1.9)).configured().is_new()


@each_case("header", [":SENS:FREQ:STAR", ":FORM", ":SENS:SWE:POIN"])
def test_a_refused_setting_is_named_and_nothing_is_measured_with_the_former_one(header):
    bench = Bench()
    bench.before = lambda message: (
        bench.faults.set("REFUSE_SETTINGS") if message.startswith(header) else bench.faults.clear()
    )
    with raises_fault(VNA_SETTINGS, header):
        bench.configured()
    assert bench.driver.state.sweep is None
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()


@each_case(
    "settings, shown",
    [
        (replace(SWEEP, analyzer=AnalyzerSettings(30_000.0)), ("0, 10, 20, 50",)),
        (replace(SWEEP, analyzer=AnalyzerSettings(averages=65_536)), ("65535",)),
        (replace(SWEEP, analyzer=AnalyzerSettings(output_power="high")), ("LOW, HIGH",)),
        (SweepSettings(4999.0, 6e9, 501), (5000, "6000000000 Hz")),
        (SweepSettings(math.nan, 6e9, 501), ("nan",)),
        (SweepSettings(1e9, 6.1e9, 501), ("6100000000 Hz", "6000000000 Hz")),
        (SweepSettings(2e9, 1e9, 501), ("1000000000 Hz", "2000000001")),
        (SweepSettings(1e9, 2e9, 1), (1, 2, 4000)),
        (SweepSettings(1e9, 2e9, 4001), (4001, 4000)),
    ],
)
def test_what_the_instrument_does_not_have_is_refused_before_anything_is_sent(settings, shown):
    bench = Bench().configured()
    with raises_fault(common_faults.NOT_ALLOWED, *shown):
        bench.driver.set_frequency_sweep(settings)
    assert bench.sent == []


def test_another_grid_is_refused_and_its_own_in_single_precision_accepted():
    sweep = SweepSettings(600e6, 6e9, 501)
    check_frequencies(sweep.frequencies_hz().astype(np.float32).astype(np.float64), sweep)
    for grid_hz in (
        SweepSettings(600e6, 5.9e9, 501).frequencies_hz(),
        SweepSettings(600.002e6, 6e9, 501).frequencies_hz(),
        SweepSettings(600e6, 6.00001e9, 501).frequencies_hz(),
        np.geomspace(600e6, 6e9, 501),
    ):
        with raises_fault(VNA_SETTINGS):
            print(grid_hz, check_frequencies(grid_hz, sweep))


@each_case(
    "name, value",
    [
        ("attempts", 0),
        ("max_frequency_hz", 1.0),
        ("min_level_db", 1.0),
        ("accepted_calibrations", (1, 6)),
        *(("analyzer", one) for one in ("", "ms2027c", "os.system", "a:b:c")),
        ("analyzer_options", {"port": 1}),
        # The data depend on it.
        ("unanswered_queries", [":SENS:FREQ:STAR?"]),
    ],
)
def test_parameters_that_make_no_sense_are_named(name, value):
    with raises_fault((common_faults.NOT_ALLOWED, common_faults.CONFIGURATION), name):
        record_from(VnaParameters, {name: value}, "vna_acquisition")


# What is not answered.


@each_case("query", list(OPTIONAL))
@each_case("answer", [b"", b"-113", b'-400,"unknown"', b'"-230"'])
def test_a_query_without_an_answer_is_named_and_left_out_where_that_is_configured(query, answer):
    bench = Bench(attempts=2, request_timeout_s=20.0)
    bench.answers(query, answer)
    with raises_fault((VNA_SILENT, VNA_FAILED, VNA_SETTINGS), query, "unanswered_queries"):
        bench.configured()
    bench = Bench(unanswered_queries=(query,))
    bench.answers(query, answer)
    bench.configured()
    bench.driver.get_trace()
    (remark,) = bench.driver.state.last_quality
    assert remark.fault == VNA_DOUBTFUL
    assert bench.driver.get_trace().quality == ()
    assert query not in bench.sent


def test_every_answer_may_have_quotes():
    bench = Bench()
    bench.vna.on_answer = lambda query, right: (
        right if "DATA" in query or query in ("*IDN?", ":TRAC:PRE? 1") else b'"%s" \n' % right[:-1]
    )
    assert bench.configured().driver.state.sweep == ACCEPTED
    bench.driver.get_trace()


# The calibration.


def test_calibration_is_read_by_its_meaning(bench):
    for status in list(CalibrationStatus)[: CalibrationStatus.NOT_REPORTED]:
        bench.is_like(calibration_accuracy=int(status))
        assert bench.driver.check_calibration_status() is status
        assert bench.driver.state.calibration is status
    for answer in ("5", "-1", "1.5", " ", "nan", "high", "0_1"):
        bench.answers(":SENS:CORR:COLL:STAT:ACC?", answer.encode())
        with raises_fault(VNA_FAILED, 9, error=VnaSweepError):
            print(answer, bench.driver.check_calibration_status())


def test_a_calibration_without_s21_is_none():
    bench = Bench(InstrumentScene(calibrated_parameters=1))
    bench.driver.connect_to_vna(ADDRESS)
    status = bench.driver.check_calibration_status()
    assert status is CalibrationStatus.NONE
    refusal = bench.driver.calibration_refusal(status)
    assert refusal.fault == NOT_CALIBRATED and "S11" in str(refusal)
    details = {"parameters": ["S11"], "is_corrected": True, "temperature_c": 40.0}
    assert bench.driver.state.calibration_details == details
    bench.is_like(calibrated_parameters=5)
    assert bench.driver.check_calibration_status() is CalibrationStatus.HIGH


def test_a_calibration_that_a_setting_ends_is_reported_once_and_survives_the_next_set_up():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    bench.faults.set("LOSES_CALIBRATION", 1)
    with raises_fault(NOT_CALIBRATED):
        bench.driver.set_frequency_sweep(SWEEP)
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()
    bench.faults.clear()  # the operator calibrates
    bench.faults.set("LOSES_CALIBRATION")
    bench.driver.set_frequency_sweep(SWEEP)
    assert bench.is_new()


@pytest.mark.parametrize("status", [CalibrationStatus.NONE, CalibrationStatus.LOW])
def test_a_sweep_without_an_accepted_calibration_is_refused_and_not_repeated(bench, status):
    bench.driver.get_trace()
    bench.is_like(calibration_accuracy=int(status))
    del bench.sent[:]
    with raises_fault(NOT_CALIBRATED, int(status), status.meaning):
        bench.driver.get_trace()
    assert bench.sent.count(TRIGGER) == 1
    assert bench.driver.trouble.fault == NOT_CALIBRATED
    # A new link would set up the sweep while somebody calibrates.
    assert bench.driver.state.linked
    bench.is_like(calibration_accuracy=3)
    assert len(bench.driver.get_trace().quality) == 1
