"""Settings are read before they are written; what an instrument does not report is learned once."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case
from driver_bench import ADDRESS, OTHER_IDENTITY, SWEEP, Bench
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common import faults as common_faults
from gpr20_common.mid.codec import record_from
from gpr20_survey.faults import NOT_CALIBRATED, VNA_DOUBTFUL, VNA_SETTINGS
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition.errors import VnaNotReadyError
from gpr20_vna_acquisition.mid.ms2026c_commands import HOLD, check_frequencies
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

OPTIONAL = [":SENS:TRACE1:DOM?", ":SENS:TRAC:TOT?", ":SENS:SWE:IFBW?", ":SOUR:POW?"]


def commands(bench: Bench) -> set:
    return {one for one in bench.vna.sent if "?" not in one and not one.startswith("<")}


def with_settings(*settings) -> SweepSettings:
    return replace(SWEEP, analyzer=AnalyzerSettings(*settings))


# What can be asked for.


@each_case(
    "settings, header, value",
    [
        ((20.0, 0, ""), ":SENS:SWE:IFBW", "20"),
        ((0.0, 16, ""), ":SENS:AVER:COUN", "16"),
        ((0.0, 0, "LOW"), ":SOUR:POW", "LOW"),
    ],
)
def test_a_setting_of_the_survey_is_made_and_the_others_are_left(settings, header, value):
    bench = Bench()
    before = dict(bench.vna.settings)
    bench.driver.connect_to_vna(ADDRESS)
    accepted = bench.driver.set_frequency_sweep(with_settings(*settings))
    assert bench.vna.settings[header] == value
    assert f"{header} {value}" in bench.vna.sent
    left = {":SENS:SWE:IFBW", ":SENS:AVER:COUN", ":SOUR:POW"} - {header}
    assert {one: bench.vna.settings[one] for one in left} == {one: before[one] for one in left}
    assert accepted.fulfils(with_settings(*settings))
    assert bench.driver.get_trace().analyzer == accepted.analyzer


@each_case(
    "settings, shown",
    [
        (with_settings(30_000.0, 0, ""), ("0, 10, 20, 50",)),
        (with_settings(0.0, 65_536, ""), ("65535",)),
        (with_settings(0.0, 0, "high"), ("LOW, HIGH",)),
        (SweepSettings(4999.0, 6e9, 501), (5000, "6000000000 Hz")),
        (SweepSettings(math.nan, 6e9, 501), ("nan",)),
        (SweepSettings(1e9, 6.1e9, 501), ("6100000000 Hz", "6000000000 Hz")),
        (SweepSettings(2e9, 1e9, 501), ("2000000000 Hz", "1000000000 Hz")),
        # Closer than the synthesizer's step.
        (SweepSettings(1e9, 1e9 + 9.9, 501), ("1000000000",)),
        (SweepSettings(1e9, 2e9, 1), (1, 2, 4000)),
        (SweepSettings(1e9, 2e9, 4001), (4001, 4000)),
    ],
)
def test_what_the_instrument_does_not_have_is_refused_before_anything_is_sent(settings, shown):
    bench = Bench().configured()
    del bench.vna.sent[:]
    with raises_fault(common_faults.NOT_ALLOWED, *shown):
        bench.driver.set_frequency_sweep(settings)
    assert bench.vna.sent == []


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
        ("settle_s", math.nan),
        ("attempts", 0),
        ("vxi11_port", 70000),
        ("transfer_format", "REAL,64"),
        ("max_frequency_hz", 1.0),
        ("min_level_db", 0.0),
        ("poll_interval_s", 1e-300),
        ("link_check_s", 3601.0),
        ("model", " "),
        ("accepted_calibrations", (1, 6)),
    ],
)
def test_parameters_that_make_no_sense_are_named(name, value):
    with raises_fault((common_faults.NOT_ALLOWED, common_faults.CONFIGURATION), name):
        record_from(VnaParameters, {name: value}, "vna_acquisition")


# What is written.


def test_only_the_setting_that_differs_is_written():
    bench = Bench().configured()
    del bench.vna.sent[:]
    bench.driver.set_frequency_sweep(SWEEP)
    assert commands(bench) == {":INIT:IMM"}
    bench.vna.settings[":SENS:TRACE1:SPAR"] = "S11"
    bench.driver.set_frequency_sweep(SWEEP)
    assert commands(bench) == {":SENS:TRACE1:SPAR S21", ":INIT:IMM"}


def test_a_calibration_that_a_setting_ends_is_reported_once_and_survives_the_next_setup():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    bench.lose_calibration_at(":SENS:FREQ:STAR ")
    with raises_fault(NOT_CALIBRATED):
        bench.driver.set_frequency_sweep(SWEEP)
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()
    bench.vna.calibration = "1"  # the operator calibrates
    bench.driver.set_frequency_sweep(SWEEP)
    bench.driver.get_trace()
    assert bench.vna.calibration == "1"


def test_an_instrument_that_loses_its_calibration_when_it_is_held_says_so():
    bench = Bench().configured()
    bench.driver.disconnect_from_vna()
    bench.lose_calibration_at(":INIT:CONT OFF")
    with raises_fault(NOT_CALIBRATED, HOLD.name):
        bench.configured()


# What is not answered.


@each_case("query", OPTIONAL)
@each_case("code", ["", "-113", '-400,"unknown"', '"-230"'])
def test_a_query_without_an_answer_is_learned_once_and_remarked(query, code):
    bench = Bench(max_level_db=60.0)
    ask = bench.vna.answer
    if code:
        # An error code is no answer.
        bench.vna.answer = lambda one: code.encode() if one == query else ask(one)
    else:
        bench.vna.unanswered = [query]
    bench.configured()
    assert bench.vna.sent.count(query) == (1 if code else 2)
    bench.driver.get_trace()
    (remark,) = bench.driver.state.last_quality
    assert remark.fault == VNA_DOUBTFUL
    del bench.vna.sent[:]
    assert bench.driver.get_trace().quality == ()
    assert query not in bench.vna.sent
    # It is tried again at each new set-up.
    bench.vna.answer, bench.vna.unanswered = ask, []
    bench.driver.set_frequency_sweep(SWEEP)
    assert query in bench.vna.sent
    assert bench.driver.get_trace().quality == ()


def test_another_instrument_is_asked_again():
    bench = Bench()
    bench.vna.unanswered = [":SOUR:POW?", ":TRAC:PRE? 1"]
    assert bench.configured().driver.state.sweep.analyzer.output_power == ""
    bench.vna.unanswered = []
    bench.vna.identity = OTHER_IDENTITY
    bench.vna.preamble["SN"] = "7654321"
    assert bench.configured().driver.state.sweep.analyzer.output_power == "HIGH"


def test_every_answer_may_have_quotes():
    bench = Bench()
    answer = bench.vna.answer
    bench.vna.answer = lambda query: (
        answer(query)
        if "DATA" in query or query in ("*IDN?", ":TRAC:PRE? 1")
        else b'"%s" \n' % answer(query)
    )
    assert bench.configured().driver.state.sweep.analyzer == AnalyzerSettings(10_000.0, 1, "HIGH")
    bench.driver.get_trace()


@pytest.mark.parametrize("silences, known", [(3, True), (4, False)])
def test_a_query_that_was_answered_before_is_soon_not_taken_for_unknown(silences, known):
    bench = Bench()
    # What a preamble says need not be asked for.
    bench.vna.preamble = None
    bench.configured()
    left = list(range(silences))

    def before(message: str) -> None:
        bench.vna.unanswered = [":SENS:TRACE1:DOM?"] if left else []
        if message == ":SENS:TRACE1:DOM?" and left:
            left.pop()

    bench.vna.before = before
    bench.driver.get_trace()
    del bench.vna.sent[:]
    bench.driver.get_trace()
    assert (":SENS:TRACE1:DOM?" in bench.vna.sent) is known


@given(st.integers(2, 4000), st.integers(5000, 5_999_000_000))
def test_grid_is_exact_where_single_precision_is_not(points, start_hz):
    grid_hz = SweepSettings(float(start_hz), 6e9, points).frequencies_hz()
    assert grid_hz.dtype == np.float64 and len(grid_hz) == points
    assert grid_hz[0] == start_hz and grid_hz[-1] == 6e9
    assert (np.diff(grid_hz) > 0).all()
    middle = points // 2
    exact = start_hz + middle * (6_000_000_000 - start_hz) / (points - 1)
    assert abs(grid_hz[middle] - exact) < 1e-5
