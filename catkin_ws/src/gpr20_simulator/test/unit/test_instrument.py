"""What the instrument understands, and what it says of itself, without network.

After the programming manual of the MS20xxC (Anritsu 10580-00306).
"""

from __future__ import annotations

import pytest
from case_kit import each_case
from vna_bench import new_bench

from gpr20_simulator.low.message_device import NetworkFault
from gpr20_simulator.mid.analyzer.instrument_scene import Power
from gpr20_simulator.mid.analyzer.scpi import (
    ScpiError,
    frequency_between,
    number_between,
    whole_number_between,
)


@pytest.fixture
def bench(request):
    return new_bench(request)


# The language.


@each_case(
    "read, texts",
    [
        (
            frequency_between,
            ["", "nan", "inf", "1_000", "600 MS", "1e999", "-6e8", "7GHZ", "4999", "0x10", "6e8 6"],
        ),
        (whole_number_between, ["4999", "6000000001", "5000.5", "NAN", "5000HZ", ""]),
        # In no time, however long they are.
        (number_between, ["1" * 40_000 + "X", "1" * 65, "1E" + "0" * 64, "." * 40_000]),
    ],
)
def test_what_is_no_number_in_range_is_refused(read, texts):
    for text in texts:
        with pytest.raises(ScpiError):
            print(text, read(text, 5000, 6_000_000_000))


# The instrument.


def test_identity_comes_from_the_scene_and_is_quoted(request, bench):
    assert bench.send("*IDN?").answer == b'"Anritsu,MS2026C/2,SIMULATED,1.23"\n'
    other = new_bench(request, model="MS2036C/2/10", serial="SIMULATED-1")
    assert other.ask("*idn?\r\n") == '"Anritsu,MS2036C/2/10,SIMULATED-1,1.23"'
    assert other.ask(":SYST:OPT?") == "2/10"
    assert new_bench(request, model="MS2026C").ask(":SYSTem:OPTions?") == "NONE"


def test_power_on_state_is_that_of_the_manual_also_after_a_preset(bench):
    def check():
        assert bench.ask(":FREQ:STAR?;:FREQ:STOP?;:SWE:POIN?") == "5000;6000000000;201"
        assert bench.ask(":FREQ:CENT?;:FREQ:SPAN?") == "3000002500;5999995000"
        assert bench.ask(":SWE:IFBW?;:AVER:COUN?;:FORM?;:SWE:TYPE?") == "10000;1;ASC;CONT"
        parameters = bench.ask(":TRAC1:SPAR?;:TRAC2:SPAR?;:TRAC3:SPAR?;:TRAC4:SPAR?")
        assert parameters == "S11;S12;S21;S22"
        assert bench.ask(":CALC1:FORM?;:CALC2:FORM?;:TRAC:TOT?;:TRAC:SEL?") == "SMIT;LMAG;4;TR1"
        assert bench.ask(":INIT:CONT?;:INIT:HOLD?;:SOUR:POW?;:INP:GAIN:MODE?") == "1;0;HIGH;AUTO"
        assert bench.ask(":INST?;:INST:NSEL?;:RFON?") == '"MWVNA";26;1'

    check()
    bench.send(":INIT:CONT OFF;:SWE:POIN 77;:FORM REAL,32;:SOUR:POW LOW;:CALC2:FORM SWR")
    bench.send(":SYST:PRES")
    check()


@each_case(
    "command, query, answer",
    [
        ("FREQ:STAR 600MHZ", "FREQ:STAR?", "600000000"),
        ("  FREQ:STAR 0.6 gHz ;:SWE:POIN 2\r\n", ":sense:FREQuency:start?", "600000000"),
        # A later command needs its colon.
        ("SWE:POIN 77;SWE:POIN 78", "SWE:POIN?", "77"),
        ('DISP "A;B";:FREQ:STAR +6.0e+8 HZ', "FREQ:STAR?", "600000000"),
        ("SENSE:FREQUENCY:STOP 2.5 GHZ", "SENS:FREQ:STOP?", "2500000000"),
        ("FREQ:STOP 1GHZ;:FREQ:STAR 2GHZ", "FREQ:STAR?;:FREQ:STOP?", "2000000000;2000000000"),
        ("FREQ:CENT 2GHZ;:FREQ:SPAN 1GHZ", "FREQ:STAR?;:FREQ:STOP?", "1500000000;2500000000"),
        ("SWE:POIN 4001", "SWE:POIN?", "4001"),
        ("FORM real,32", "FORM?", "REAL,32"),
        ("FORMAT:READINGS:DATA INTEGER, 32", "FORM:DATA?", "INT,32"),
        ("TRAC3:SPARams s22", "SENS:TRAC3:SPAR?", "S22"),
        ("CALC4:FORM LM/2", "CALC4:FORM?;:TRAC:SEL?", "LM/2;TR4"),
        ("TRAC3:SEL", "TRAC:SEL?", "TR3"),
        ("CORR OFF", "CORR:STAT?;:SENS:CORR:COLL:STAT:ACC?", "0;0"),
        ("SWE:TYPE SING", "SWE:TYPE?;:INIT:HOLD?", "SING;1"),
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
        ("FREQU:STAR 1GHZ", "FREQ:STAR?"),
        ("SWE:POIN 4002", "SWE:POIN?"),
        ("SWE:IFBW 30000", "SWE:IFBW?"),
        ("AVER:COUN 0", "AVER:COUN?"),
        ("TRAC1:SPAR S31", "TRAC1:SPAR?"),
        ("SWE:TYPE ONCE", "SWE:TYPE?"),
    ],
)
def test_invalid_settings_keep_the_former_value(bench, command, query):
    before = bench.ask(query)
    assert bench.send(command).answer == b""
    assert bench.ask(query) == before


@each_case(
    "query",
    [
        "*OPC?",
        ":CALC9:DATA? SDAT",
        ":CALC1:DATA? SMEM",
        ":?",
    ],
)
def test_unknown_queries_get_no_answer(bench, query):
    outcome = bench.send(query)
    assert (outcome.answer, outcome.fault) == (b"", NetworkFault.NONE)


@each_case(
    "accuracy, interpolated, covers, answers",
    [
        (3, True, 15, "3;4;15;RF2P;1;1"),
        (0, True, 15, "0;0;0;;0;0"),
    ],
)
def test_calibration_is_that_of_the_scene(request, accuracy, interpolated, covers, answers):
    bench = new_bench(
        request,
        calibration_accuracy=accuracy,
        calibration_interpolated=interpolated,
        calibrated_parameters=covers,
    )
    # Without a calibration there is no correction.
    bench.send(":CORR ON")
    queries = (
        ":SENS:CORR:COLL:STAT:ACC?", ":CORR:COLL:STAT?", ":SENS:CAL:STAT?",
        ":SENS:CORR:COLL:TYPE?", ":SENS:CORR:COLL:INT?", ":CORR:STAT?",
    )  # fmt: skip
    assert ";".join(bench.ask(one) for one in queries) == answers


def test_calibration_at_other_power_is_less_accurate(request):
    bench = new_bench(request, calibration_power=Power.LOW)
    assert bench.ask(":CORR:COLL:STAT:ACC?") == "2"
    bench.send(":SOUR:POW LOW")
    assert bench.ask(":CORR:COLL:STAT:ACC?") == "1"
