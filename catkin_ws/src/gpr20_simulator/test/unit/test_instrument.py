"""The instrument's commands, without network; sweeps take no time unless said."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rpc_wire import wait_until
from vna_bench import (
    Bench,
    HandClock,
    ascii_numbers,
    block_content,
    complex_numbers,
    real_numbers,
)

from gpr20_simulator.errors import FaultError
from gpr20_simulator.low.message_device import Conduct
from gpr20_simulator.mid.faults import FaultBoard
from gpr20_simulator.mid.probe_medium import probed_sweep
from gpr20_simulator.mid.scpi import HeaderPattern
from gpr20_simulator.mid.vna_commands import SETTINGS


@pytest.fixture
def bench():
    one = Bench()
    yield one
    one.stop()


def new_bench(request, **options):
    one = Bench(**options)
    request.addfinalizer(one.stop)
    return one


def swept(bench, points=11):
    """Hold, set the sweep, run it once and return its data in REAL,32."""
    bench.send(f":INIT:CONT OFF;:SWE:POIN {points};:SENS:TRACE1:SPAR S21;:FORM REAL,32;:INIT:IMM")
    wait_until(lambda: bench.ask(":STAT:OPER?") == "256", "end of the sweep")
    return bench.send(":CALC1:DATA? SDAT").answer


def test_identity_is_quoted_and_says_simulated(bench):
    assert bench.send("*IDN?").answer == b'"Anritsu,MS2026C/2,SIMULATED,1.23"\n'


def test_identity_comes_from_the_scene(request):
    bench = new_bench(request, model="MS2036C/2/10", serial="S-1")
    assert bench.ask("*idn?\r\n") == '"Anritsu,MS2036C/2/10,S-1,1.23"'
    assert bench.ask(":SYST:OPT?") == "2/10"


def test_instrument_without_options_says_none(request):
    assert new_bench(request, model="MS2026C").ask(":SYSTem:OPTions?") == "NONE"


def test_original_software_is_understood_word_by_word(bench):
    assert bench.ask(":SENS:CORR:COLL:STAT:ACC?") == "1"
    for command in (
        ":SENS:FREQ:STAR 600000000",
        ":SENS:FREQ:STOP 6000000000",
        ":SENS:SWE:POIN 501",
        ":SENS:TRACE1:SPAR S21",
        ":CALC1:FORM SMITh",
    ):
        assert bench.send(command).answer == b""
    assert len(ascii_numbers(bench.send(":SENSE1:FREQ:DATA?").answer)) == 501
    assert len(ascii_numbers(bench.send(":CALC1:DATA? SDAT").answer)) == 1002
    assert bench.ask(":CALC1:FORM?") == "SMIT"


def test_power_on_state_is_that_of_the_manual(bench):
    assert bench.ask(":FREQ:STAR?;:FREQ:STOP?;:SWE:POIN?") == "5000;6000000000;201"
    assert bench.ask(":FREQ:CENT?;:FREQ:SPAN?") == "3000002500;5999995000"
    assert bench.ask(":SWE:IFBW?;:AVER:COUN?;:FORM?;:SWE:TYPE?") == "10000;1;ASC;CONT"
    assert bench.ask(":TRAC1:SPAR?;:TRAC2:SPAR?;:TRAC3:SPAR?;:TRAC4:SPAR?") == "S11;S12;S21;S22"
    assert bench.ask(":CALC1:FORM?;:CALC2:FORM?;:TRAC:TOT?;:TRAC:SEL?") == "SMIT;LMAG;4;TR1"
    assert bench.ask(":INIT:CONT?;:INIT:HOLD?;:SOUR:POW?;:INP:GAIN:MODE?") == "1;0;HIGH;AUTO"
    assert bench.ask(":INST?;:INST:NSEL?;:RFON?") == '"MWVNA";26;1'


@pytest.mark.parametrize(
    ("command", "query", "answer"),
    [
        ("FREQ:STAR 600MHZ", "FREQ:STAR?", "600000000"),
        ("SENSE:FREQUENCY:STOP 2.5 GHZ", "SENS:FREQ:STOP?", "2500000000"),
        ("FREQ:STAR 5000.5", "FREQ:STAR?", "5000.500"),
        ("SWE:POIN 4001", "SWE:POIN?", "4001"),
        ("SWE:POIN 2", "SWE:POIN?", "2"),
        ("SWE:IFBW 100000", "SWE:IFBW?", "100000"),
        ("SWE:IFBW 1 KHZ", "SWE:IFBW?", "1000"),
        ("AVER:COUN 16", "AVER:COUN?", "16"),
        ("FORM real,32", "FORM?", "REAL,32"),
        ("FORMAT:READINGS:DATA INTEGER, 32", "FORM:DATA?", "INT,32"),
        ("TRAC3:SPARams s22", "SENS:TRAC3:SPAR?", "S22"),
        ("TRAC2:DOM DISTANCE", "TRAC2:DOM?", "DIST"),
        ("CALC4:FORM LM/2", "CALC4:FORM?;:TRAC:SEL?", "LM/2;TR4"),
        ("TRAC3:SEL", "TRAC:SEL?", "TR3"),
        ("TRAC:TOT 1", "TRAC:TOT?", "1"),
        ("SOUR:POW LOW", "SOUR:POW?", "LOW"),
        ("INP:GAIN:MODE FIXed", "INP:GAIN:MODE?", "FIX"),
        ("RFON OFF", "RFON:STAT?", "0"),
        ("CORR OFF", "CORR:STAT?", "0"),
        ("SWE:TYPE SING", "SWE:TYPE?;:INIT:HOLD?", "SING;1"),
        ("SWE:TYPE EXTernal", "SWE:TYPE?", "EXT"),
        ("INIT:HOLD ON", "INIT:HOLD?;:INIT:CONT?", "1;0"),
    ],
)
def test_settings_are_read_back_in_their_short_form(bench, command, query, answer):
    bench.send(command)
    assert bench.ask(query) == answer


@pytest.mark.parametrize(
    ("command", "query"),
    [
        ("FREQ:STAR 4999", "FREQ:STAR?"),
        ("FREQ:STOP 6.1GHZ", "FREQ:STOP?"),
        ("FREQ:STAR NAN", "FREQ:STAR?"),
        ("SWE:POIN 4002", "SWE:POIN?"),
        ("SWE:POIN 1", "SWE:POIN?"),
        ("SWE:POIN 10.5", "SWE:POIN?"),
        ("SWE:IFBW 30000", "SWE:IFBW?"),
        ("AVER:COUN 0", "AVER:COUN?"),
        ("FORM REAL,64", "FORM?"),
        ("TRAC1:SPAR S31", "TRAC1:SPAR?"),
        ("TRAC1:SPARAM S21", "TRAC1:SPAR?"),
        ("CALC1:FORM SMI", "CALC1:FORM?"),
        ("SWE:TYPE ONCE", "SWE:TYPE?"),
        ("INIT:CONT MAYBE", "INIT:CONT?"),
    ],
)
def test_invalid_settings_keep_the_former_value(bench, command, query):
    before = bench.ask(query)
    assert bench.send(command).answer == b""
    assert bench.ask(query) == before


def test_start_above_stop_takes_the_stop_along(bench):
    bench.send("FREQ:STOP 1GHZ;:FREQ:STAR 2GHZ")
    assert bench.ask("FREQ:STAR?;:FREQ:STOP?") == "2000000000;2000000000"
    bench.send("FREQ:STOP 1GHZ")
    assert bench.ask("FREQ:STAR?;:FREQ:STOP?") == "1000000000;1000000000"


def test_centre_and_span_set_both_ends(bench):
    bench.send("FREQ:CENT 2GHZ;:FREQ:SPAN 1GHZ")
    assert bench.ask("FREQ:STAR?;:FREQ:STOP?") == "1500000000;2500000000"


@pytest.mark.parametrize(
    "query",
    ["*OPC?", "*ESR?", ":SYST:ERR?", ":CALC9:DATA? SDAT", ":CALC1:DATA? SMEM", ":FOO?", "?", ":?"],
)
def test_unknown_queries_get_no_answer(bench, query):
    outcome = bench.send(query)
    assert (outcome.answer, outcome.conduct) == (b"", Conduct.REPLY)


@pytest.mark.parametrize(("accuracy", "state", "mask"), [(0, "0", "0"), (3, "4", "15")])
def test_calibration_is_that_of_the_scene(request, accuracy, state, mask):
    bench = new_bench(request, calibration_accuracy=accuracy)
    assert bench.ask(":SENS:CORR:COLL:STAT:ACC?") == str(accuracy)
    assert bench.ask(":CORR:COLL:STAT?;:CAL:STAT?") == f"{state};{mask}"
    assert bench.ask(":CORR:STAT?") == str(int(accuracy > 0))


def test_correction_needs_a_calibration(request):
    bench = new_bench(request, calibration_accuracy=0)
    bench.send(":CORR ON")
    assert bench.ask(":CORR?") == "0"


def test_switched_off_correction_reads_as_no_calibration(bench):
    bench.send(":CORR OFF")
    assert bench.ask(":SENS:CORR:COLL:STAT:ACC?") == "0"


def test_preset_brings_back_the_power_on_state(bench):
    bench.send(":INIT:CONT OFF;:SWE:POIN 77;:FORM REAL,32;:SYST:PRES")
    assert bench.ask(":SWE:POIN?;:FORM?;:INIT:CONT?") == "201;ASC;1"


def test_triggered_sweep_gives_points_of_one_new_sweep(bench):
    first = complex_numbers(real_numbers(swept(bench)))
    number = probed_sweep(first[0])
    assert [probed_sweep(value) for value in first] == [number] * 11
    second = complex_numbers(real_numbers(swept(bench)))
    assert [probed_sweep(value) for value in second] == [number + 1] * 11


def test_status_bit_is_off_while_a_triggered_sweep_runs(request):
    clock = HandClock()
    bench = new_bench(request, clock=clock, seconds_per_point=0.001)
    bench.send(":INIT:CONT OFF;:INIT:IMM")
    assert bench.ask(":STAT:OPER?") == "0"
    clock.advance(1.0)
    wait_until(lambda: bench.ask(":STAT:OPER?") == "256", "end of the sweep")
    bench.send(":INIT:IMM")
    assert bench.ask(":STAT:OPER?") == "0"


def test_delayed_setting_reads_back_only_when_it_has_taken_effect(request):
    clock = HandClock()
    bench = new_bench(request, clock=clock, setting_delay_s=2.0)
    bench.send(":SWE:POIN 77;:SWE:POIN 1")
    clock.advance(1.9)
    assert bench.ask(":SWE:POIN?") == "201"
    clock.advance(0.2)
    assert bench.ask(":SWE:POIN?") == "77"


def test_delayed_setting_is_forgotten_by_a_preset(request):
    clock = HandClock()
    bench = new_bench(request, clock=clock, setting_delay_s=2.0)
    bench.send(":SWE:POIN 77;:SYST:PRES")
    clock.advance(3.0)
    assert bench.ask(":SWE:POIN?") == "201"


def test_external_trigger_never_comes(bench):
    bench.send(":SWE:TYPE EXT;:INIT:IMM")
    number = bench.sweeper.sweep_number
    assert not bench.sweeper.is_running
    assert bench.sweeper.sweep_number == number


def test_ascii_and_binary_data_are_the_same_numbers(bench):
    binary = real_numbers(swept(bench))
    bench.send("FORM ASC")
    text = ascii_numbers(bench.send(":CALC1:DATA? SDAT").answer).astype(np.float32)
    assert text.tobytes() == binary.tobytes()
    assert bench.send(":TRAC? 1").answer == bench.send(":CALC1:DATA? SDAT").answer
    bench.send("FORM INT,32")
    steps = np.frombuffer(block_content(bench.send(":CALC1:DATA? SDAT").answer), "<i4")
    assert steps == pytest.approx(binary * 1e6, abs=1.0)


def test_ascii_ends_with_comma_and_newline_unless_told_otherwise(request):
    answer = new_bench(request).send(":CALC1:DATA? SDAT").answer
    assert answer.endswith(b",\n")
    bench = new_bench(request, trailing_comma=False, trailing_newline=False, header_digits=8)
    answer = bench.send(":CALC1:DATA? SDAT").answer
    assert answer.startswith(b"#80000")
    assert answer[-1:].isdigit()
    assert len(ascii_numbers(answer)) == 402


def test_frequencies_are_those_of_the_sweep(bench):
    bench.send("FREQ:STAR 600MHZ;:FREQ:STOP 6GHZ;:SWE:POIN 501")
    expected_hz = np.linspace(600e6, 6e9, 501)
    assert np.array_equal(ascii_numbers(bench.send("FREQ:DATA?").answer), expected_hz)
    bench.send("FORM REAL,32")
    assert real_numbers(bench.send("SENS4:FREQ:DATA?").answer) == pytest.approx(
        expected_hz, abs=256
    )


def test_s12_is_s21_and_reflections_are_not(bench):
    transmission = swept(bench)
    bench.send("TRAC2:SPAR S12;:TRAC3:SPAR S11")
    assert bench.send(":CALC2:DATA? SDAT").answer == transmission
    assert bench.send(":CALC3:DATA? SDAT").answer != transmission


def test_displayed_data_follow_the_graph_type_and_complex_data_do_not(bench):
    before = swept(bench)
    bench.send("CALC1:FORM REAL")
    assert bench.send(":CALC1:DATA? SDAT").answer == before
    shown = real_numbers(bench.send(":CALC1:DATA? FDAT").answer)
    assert list(shown) == list(real_numbers(before)[0::2])


def test_preamble_describes_the_sweep(bench):
    bench.send("FREQ:STAR 600MHZ;:SWE:POIN 501;:SWE:TYPE SING")
    pairs = dict(
        pair.split("=")
        for pair in block_content(bench.send("TRAC:PRE?").answer).decode().split(",")
    )
    assert pairs["SN"] == "SIMULATED"
    assert float(pairs["TRACE_1_START_FREQ"]) == 600.0
    assert pairs["TRACE_1_DSP_DATA_POINTS"] == "501"
    assert (pairs["SWEEP_TYPE"], pairs["CAL_CORRECTION"], pairs["RF_SOURCE_POWER"]) == (
        "0",
        "0",
        "1",
    )


def test_reset_loses_the_network(bench):
    assert not bench.instrument.network_lost
    assert bench.send("*RST").conduct is Conduct.GO_SILENT
    assert bench.instrument.network_lost


def test_data_replies_are_captured_byte_by_byte(bench):
    data = swept(bench)
    bench.ask("*IDN?")
    frequencies = bench.send("FREQ:DATA?").answer
    assert bench.capture.saved == [("sdat", data), ("freq", frequencies)]


def test_hang_gets_no_reply_for_as_many_messages_as_counted(bench):
    bench.faults.set("hang", 2)
    conducts = [bench.send("*IDN?").conduct for _ in range(3)]
    assert conducts == [Conduct.NO_REPLY, Conduct.NO_REPLY, Conduct.REPLY]
    assert bench.instrument.opened() is Conduct.REPLY


@pytest.mark.parametrize(
    ("fault", "conduct"), [("HANG", Conduct.NO_REPLY), ("DROP", Conduct.DROP_CONNECTIONS)]
)
def test_fault_that_stays_hits_new_links_too_until_it_is_cleared(bench, fault, conduct):
    bench.faults.set(fault)
    assert bench.instrument.opened() is conduct
    assert [bench.send("*IDN?").conduct for _ in range(5)] == [conduct] * 5
    bench.faults.clear()
    assert bench.instrument.opened() is Conduct.REPLY
    assert bench.ask("*IDN?").startswith('"Anritsu')


def test_silent_fault_keeps_answers_back(bench):
    bench.faults.set("SILENT", 1)
    assert bench.send("*IDN?").answer == b""
    assert bench.send("*IDN?").answer != b""


@pytest.mark.parametrize("data_format", ["ASC", "REAL,32"])
def test_truncated_block_lacks_its_last_nine_bytes(bench, data_format):
    swept(bench)
    bench.send(f"FORM {data_format}")
    whole = bench.send(":CALC1:DATA? SDAT").answer
    bench.faults.set("TRUNCATE", 1)
    assert bench.send(":CALC1:DATA? SDAT").answer == whole[:-10] + b"\n"
    assert bench.send(":CALC1:DATA? SDAT").answer == whole


def test_nan_fault_spoils_some_numbers_only(bench):
    swept(bench, points=101)
    bench.faults.set("NAN", 1)
    spoiled = np.isnan(real_numbers(bench.send(":CALC1:DATA? SDAT").answer))
    assert 0 < np.count_nonzero(spoiled) < 20
    assert not np.any(np.isnan(real_numbers(bench.send(":CALC1:DATA? SDAT").answer)))
    bench.send("FORM ASC")
    bench.faults.set("NAN", 1)
    assert np.isnan(ascii_numbers(bench.send(":CALC1:DATA? SDAT").answer)).any()


def test_garbage_is_anything_but_the_answer(bench):
    whole = swept(bench)
    bench.faults.set("GARBAGE", 1)
    garbage = bench.send(":CALC1:DATA? SDAT").answer
    assert len(garbage) == len(whole)
    assert garbage != whole
    assert bench.send(":CALC1:DATA? SDAT").answer == whole


def test_wrong_identity_is_another_maker(bench):
    bench.faults.set("WRONG_IDENTITY", 1)
    assert "Anritsu" not in bench.ask("*IDN?")
    assert "Anritsu" in bench.ask("*IDN?")


def test_stale_fault_sets_the_bit_and_keeps_the_old_data(bench):
    before = swept(bench)
    bench.faults.set("STALE", 1)
    assert swept(bench) == before
    assert swept(bench) != before


def test_refused_settings_keep_their_value_while_sweeps_go_on(bench):
    bench.faults.set("REFUSE_SETTINGS")
    bench.send("SWE:POIN 77;:FREQ:STAR 1GHZ;:FORM REAL,32;:CORR OFF;:SWE:TYPE SING")
    assert bench.ask("SWE:POIN?;:FREQ:STAR?;:FORM?;:CORR?;:SWE:TYPE?") == "201;5000;ASC;1;CONT"
    bench.send(":INIT:CONT OFF;:INIT:IMM")
    wait_until(lambda: bench.ask(":STAT:OPER?") == "256", "end of the sweep")
    bench.faults.clear()
    bench.send("SWE:POIN 77")
    assert bench.ask("SWE:POIN?") == "77"


def test_refused_setting_counts_as_one(bench):
    bench.faults.set("REFUSE_SETTINGS", 1)
    bench.send("SWE:POIN 77;:FREQ:STAR 1GHZ")
    assert bench.ask("SWE:POIN?;:FREQ:STAR?") == "201;1000000000"


@pytest.mark.parametrize(("name", "count"), [("EXPLODE", 0), ("", 0), ("HANG", -1)])
def test_unknown_fault_is_refused_with_what_is_allowed(name, count):
    with pytest.raises(FaultError, match=r"allowed are .*HANG|between 0 and"):
        FaultBoard().set(name, count)


@pytest.fixture(scope="module")
def fuzzed():
    one = Bench()
    yield one
    one.stop()


SPELLINGS = [
    one.header.pattern.replace("[", "").replace("]", "").replace("#", "1") for one in SETTINGS
] + [":CALC1:DATA", ":TRAC:DATA", ":TRAC:PRE", ":FREQ:DATA", ":INIT", ":INIT:CONT", ":STAT:OPER"]
COMMANDS = st.builds(
    "{}{} {}".format,
    st.sampled_from(SPELLINGS),
    st.sampled_from(["", "?"]),
    st.one_of(
        st.sampled_from(["", "ON", "OFF", "SDAT", "FDAT", "S21", "1", "2", "REAL,32", "1GHZ"]),
        st.text(max_size=10),
        st.integers().map(str),
        st.floats().map(str),
    ),
)


@settings(deadline=None, max_examples=150)
@given(st.one_of(st.binary(max_size=60), st.lists(COMMANDS, max_size=4).map(";".join)))
def test_no_message_breaks_the_instrument(fuzzed, message):
    data = message if isinstance(message, bytes) else message.encode("utf-8")
    if b"*RST" in data.upper():
        return
    assert fuzzed.instrument.execute(data).conduct is Conduct.REPLY
    assert fuzzed.ask("*IDN?").startswith('"Anritsu')
    start_hz, stop_hz, points = (
        float(one) for one in fuzzed.ask("FREQ:STAR?;:FREQ:STOP?;:SWE:POIN?").split(";")
    )
    assert 5e3 <= start_hz <= stop_hz <= 6e9
    assert 2 <= points <= 4001


def test_every_documented_header_of_a_setting_is_understood():
    for one in SETTINGS:
        assert HeaderPattern(one.header.pattern).match(
            one.header.pattern.replace("[", "").replace("]", "").replace("#", "2")
        ) in ((), (2,))
