"""The instrument's settings and what it says of itself, without network."""

from __future__ import annotations

from case_kit import each_case
from vna_bench import (
    ascii_numbers,
    new_bench,
)

from gpr20_simulator.low.message_device import NetworkFault


def test_identity_is_quoted_and_says_simulated(bench):
    assert bench.send("*IDN?").answer == b'"Anritsu,MS2026C/2,SIMULATED,1.23"\n'


def test_identity_comes_from_the_scene(request):
    bench = new_bench(request, model="MS2036C/2/10", serial="SIMULATED-1")
    assert bench.ask("*idn?\r\n") == '"Anritsu,MS2036C/2/10,SIMULATED-1,1.23"'
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


@each_case(
    "command, query, answer",
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
    bench.send(":SYST:PRES")
    bench.send(command)
    assert bench.ask(query) == answer


@each_case(
    "command, query",
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


@each_case(
    "query",
    ["*OPC?", "*ESR?", ":SYST:ERR?", ":CALC9:DATA? SDAT", ":CALC1:DATA? SMEM", ":FOO?", "?", ":?"],
)
def test_unknown_queries_get_no_answer(bench, query):
    outcome = bench.send(query)
    assert (outcome.answer, outcome.fault) == (b"", NetworkFault.NONE)


@each_case("accuracy, state, mask", [(0, "0", "0"), (3, "4", "15")])
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
