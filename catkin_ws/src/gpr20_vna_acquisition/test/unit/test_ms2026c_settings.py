"""Settings are read before they are written; what an instrument does not report is learned once."""

from __future__ import annotations

from dataclasses import replace

import pytest
from driver_bench import ADDRESS, SWEEP, Bench
from fault_kit import raises_fault

from gpr20_common import faults as common_faults
from gpr20_common.message import Message
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import (
    VnaConnectionError,
    VnaNotReadyError,
    VnaSweepError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.settings import HOLD

OPTIONAL = [":SENS:TRACE1:DOM?", ":SENS:TRAC:TOT?", ":SENS:SWE:IFBW?", ":SOUR:POW?"]


def commands(bench: Bench) -> list:
    return [one for one in bench.vna.sent if "?" not in one and not one.startswith("<")]


def with_settings(*settings) -> SweepSettings:
    return replace(SWEEP, analyzer=AnalyzerSettings(*settings))


@pytest.mark.parametrize(
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


@pytest.mark.parametrize(
    "settings, shown",
    [
        ((30_000.0, 0, ""), "0, 10, 20, 50"),
        ((float("nan"), 0, ""), "0, 10"),
        ((0.0, 65_536, ""), "65535"),
        ((0.0, -1, ""), "65535"),
        ((0.0, 0, "high"), "LOW, HIGH"),
    ],
)
def test_what_the_instrument_does_not_have_is_refused_before_anything_is_sent(settings, shown):
    bench = Bench().configured()
    del bench.vna.sent[:]
    with raises_fault(common_faults.NOT_ALLOWED, shown):
        bench.driver.set_frequency_sweep(with_settings(*settings))
    assert bench.vna.sent == []


@pytest.mark.parametrize("span_hz", [0.0, 0.5, 9.9])
def test_frequencies_closer_than_the_synthesizers_step_are_refused(span_hz):
    with raises_fault(common_faults.NOT_ALLOWED, "1000000000"):
        Bench().driver.set_frequency_sweep(SweepSettings(1e9, 1e9 + span_hz, 11))


def test_a_second_setup_writes_nothing():
    bench = Bench().configured()
    del bench.vna.sent[:]
    bench.driver.set_frequency_sweep(SWEEP)
    assert set(commands(bench)) == {":INIT:IMM"}


def test_only_the_setting_that_differs_is_written():
    bench = Bench().configured()
    bench.vna.settings[":SENS:TRACE1:SPAR"] = "S11"
    del bench.vna.sent[:]
    bench.driver.set_frequency_sweep(SWEEP)
    assert set(commands(bench)) == {":SENS:TRACE1:SPAR S21", ":INIT:IMM"}


def test_a_calibration_that_a_setting_ends_is_reported_once_and_survives_the_next_setup():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)

    def lose_calibration(message: str) -> None:
        if message.startswith(":SENS:FREQ:STAR "):
            bench.vna.calibration = "0"

    bench.vna.before = lose_calibration
    with raises_fault(faults.CALIBRATION_LOST):
        bench.driver.set_frequency_sweep(SWEEP)
    with pytest.raises(VnaNotReadyError):
        bench.driver.get_trace()
    bench.vna.calibration = "1"  # the operator calibrates
    bench.driver.set_frequency_sweep(SWEEP)
    bench.driver.get_trace()
    assert bench.vna.calibration == "1"


def test_an_instrument_without_calibration_can_be_set_up():
    bench = Bench()
    bench.vna.calibration = "0"
    bench.configured()


@pytest.mark.parametrize("query", OPTIONAL)
def test_a_query_without_an_answer_is_learned_once_and_remarked(query):
    bench = Bench(max_level_db=60.0)
    bench.vna.unanswered = [query]
    bench.configured()
    assert bench.vna.sent.count(query) == 2
    bench.driver.get_trace()
    (remark,) = bench.driver.state.last_quality
    assert remark.fault == faults.SETTING_UNREPORTED
    del bench.vna.sent[:]
    assert bench.driver.get_trace().quality == ()
    assert query not in bench.vna.sent


@pytest.mark.parametrize("query", [*OPTIONAL, ":TRAC:PRE? 1"])
def test_a_query_without_an_answer_is_tried_again_at_each_new_set_up(query):
    bench = Bench(max_level_db=60.0)
    bench.vna.unanswered = [query]
    bench.configured()
    bench.vna.unanswered = []
    del bench.vna.sent[:]
    bench.driver.set_frequency_sweep(SWEEP)
    assert query in bench.vna.sent
    assert bench.driver.get_trace().quality == ()


@pytest.mark.parametrize(
    "query, answer", list(zip(OPTIONAL, ["-113", '-400,"unknown"', '"-230"', "-400"]))
)
def test_an_error_code_is_no_answer_to_a_query(query, answer):
    bench = Bench(max_level_db=60.0)
    ask = bench.vna.answer
    bench.vna.answer = lambda one: answer.encode() if one == query else ask(one)
    bench.configured()
    assert bench.vna.sent.count(query) == 1
    bench.driver.get_trace()
    (remark,) = bench.driver.state.last_quality
    assert remark.fault == faults.SETTING_UNREPORTED


def test_a_number_of_averages_below_one_is_an_error():
    bench = Bench()
    bench.vna.settings[":SENS:AVER:COUN"] = "-113"
    with raises_fault(faults.BAD_DATA, error=VnaSweepError):
        bench.configured()


def test_all_optional_queries_may_be_without_an_answer():
    bench = Bench()
    bench.vna.unanswered = [*OPTIONAL, ":SENSE1:FREQ:DATA?"]
    bench.driver.connect_to_vna(ADDRESS)
    begun_s = bench.clock.time_s
    assert bench.driver.set_frequency_sweep(SWEEP).analyzer == AnalyzerSettings(0.0, 1, "")
    assert bench.clock.time_s - begun_s < 40.0


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


def test_an_instrument_that_loses_its_calibration_when_it_is_held_says_so():
    bench = Bench().configured()
    bench.driver.disconnect_from_vna()

    def lose_calibration(message: str) -> None:
        if message == ":INIT:CONT OFF":
            bench.vna.calibration = "0"

    bench.vna.before = lose_calibration
    with raises_fault(faults.CALIBRATION_LOST, HOLD.name):
        bench.configured()


def test_another_instrument_is_asked_again():
    bench = Bench()
    bench.vna.unanswered = [":SOUR:POW?"]
    bench.configured()
    bench.vna.unanswered = []
    bench.vna.identity = '"Anritsu,MS2026C/2,7654321,1.23"'
    bench.configured()
    assert bench.driver.state.sweep.analyzer.output_power == "HIGH"


def test_a_required_query_without_an_answer_fails_within_the_limit():
    bench = Bench()
    bench.vna.unanswered = [":SENS:FREQ:STAR?"]
    bench.driver.connect_to_vna(ADDRESS)
    with raises_fault(faults.NO_ANSWER, error=VnaTimeoutError):
        bench.driver.set_frequency_sweep(SWEEP)


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


HAND = [
    (":SENS:FREQ:STAR", "700000000"),
    (":SENS:FREQ:STOP", "5000000000"),
    (":SENS:SWE:POIN", "12"),
    (":SENS:TRAC:TOT", "4"),
    (":SENS:TRACE1:SPAR", "S11"),
    (":SENS:TRACE1:DOM", "TIME"),
    (":SENS:AVER:COUN", "4"),
    (":SENS:SWE:IFBW", "20"),
    (":SOUR:POW", "LOW"),
    (":FORM", "ASC"),
    (":INIT:CONT", "1"),
]


@pytest.mark.parametrize("is_broken", [False, True])
def test_a_sweep_is_not_confirmed_after_a_change_by_hand(is_broken):
    for header, value in HAND:
        check_not_confirmed(header, value, is_broken)


def check_not_confirmed(header, value, is_broken):
    bench = Bench().configured()
    number, sweep = bench.driver.take_sweep()
    bench.vna.settings[header] = value
    left = [VnaConnectionError(Message("broken on purpose"))] * is_broken

    def break_once(message: str) -> None:
        if left:
            raise left.pop()

    bench.vna.before = break_once
    with raises_fault(faults.SETTINGS_CHANGED):
        print(header, bench.driver.confirm(number))
    assert bench.vna.settings[header] == value, "nothing may be written to prove a sweep"
    number, again = bench.driver.take_sweep()
    assert again.analyzer == sweep.analyzer and bench.driver.confirm(number).remarks == (), header
    assert bench.vna.settings[header] != value


def test_settings_restored_before_the_proof_do_not_hide_a_change():
    bench = Bench().configured()
    number, _sweep = bench.driver.take_sweep()
    bench.vna.settings[":SENS:SWE:POIN"] = "201"

    def break_once(_message: str) -> None:
        bench.vna.before = lambda _message: None
        raise VnaConnectionError(Message("broken on purpose"))

    bench.vna.before = break_once
    bench.driver.check_calibration_status()
    assert bench.vna.settings[":SENS:SWE:POIN"] == "11", "restored on the new link"
    with raises_fault(faults.SWEEP_UNCONFIRMED, number):
        bench.driver.confirm(number)


def test_only_the_last_sweep_can_be_confirmed():
    bench = Bench().configured()
    first, _sweep = bench.driver.take_sweep()
    second, _sweep = bench.driver.take_sweep()
    with raises_fault(faults.SWEEP_UNCONFIRMED, first):
        bench.driver.confirm(first)
    with pytest.raises(VnaNotReadyError):
        bench.driver.confirm(second)


@pytest.mark.parametrize(
    "outage_s, survives", [(2.0, True), (20.0, True), (30.0, True), (60.0, False)]
)
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
    else:
        with raises_fault(faults.NO_LINK, error=VnaTimeoutError):
            bench.driver.get_trace()


def test_another_serial_number_fails_the_request_at_once_until_it_is_connected():
    bench = Bench().configured()
    bench.vna.identity = '"Anritsu,MS2026C/2,7654321,1.23"'
    left = [VnaConnectionError(Message("broken on purpose"))]
    bench.vna.before = lambda message: [None for one in left if not left.clear()] and None
    bench.driver._link.drop()
    begun_s = bench.clock.time_s
    with raises_fault(faults.REPLACED, 7654321, 1234567):
        bench.driver.get_trace()
    assert bench.clock.time_s - begun_s < 1.0
    assert "7654321" in bench.driver.connect_to_vna(ADDRESS)
    bench.configured()
    bench.driver.get_trace()


def test_after_the_survey_the_instrument_sweeps_by_itself_and_is_left_alone():
    bench = Bench().configured()
    bench.driver.disconnect_from_vna()
    assert bench.vna.settings[":INIT:CONT"] == "0" or bench.vna._pending
    bench.vna.answer(":INIT:CONT?")
    assert bench.vna.settings[":INIT:CONT"] == "1" and bench.vna.local
    assert bench.vna.open_links == 0
    del bench.vna.sent[:]
    bench.clock.pass_s(60.0)
    bench.driver.check_idle_link()
    assert bench.vna.sent == []
