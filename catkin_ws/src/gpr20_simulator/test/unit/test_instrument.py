"""What the instrument understands, and what it says of itself, without network.

After the programming manual of the MS20xxC (Anritsu 10580-00306).
"""

from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case
from vna_bench import (
    POINTS,
    SWEEP_S,
    CountingProbe,
    ascii_numbers,
    new_bench,
    real_numbers,
    swept,
    timed_bench,
    wait_until,
)

from gpr20_simulator.low.message_device import NetworkFault
from gpr20_simulator.mid.analyzer.instrument_scene import Averaging, Power
from gpr20_simulator.mid.analyzer.scpi import (
    ScpiError,
    frequency_between,
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
        (frequency_between, ["1" * 40_000 + "X", "1" * 65, "1E" + "0" * 64, "." * 40_000]),
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


def test_power_on_state_is_that_of_the_manual(bench):
    assert bench.ask(":FREQ:STAR?;:FREQ:STOP?;:SWE:POIN?") == "5000;6000000000;201"
    assert bench.ask(":SWE:IFBW?;:AVER:COUN?;:FORM?;:INIT:CONT?") == "10000;1;ASC;1"
    parameters = bench.ask(":TRAC1:SPAR?;:TRAC2:SPAR?;:TRAC3:SPAR?;:TRAC4:SPAR?")
    assert parameters == "S11;S12;S21;S22"
    assert bench.ask(":TRAC:TOT?;:SOUR:POW?;:CORR?") == "4;HIGH;1"


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
        ("SWE:POIN 4001", "SWE:POIN?", "4001"),
        ("FORM real,32", "FORM?", "REAL,32"),
        ("FORMAT:READINGS:DATA REAL, 32", "FORM:DATA?", "REAL,32"),
        ("TRAC3:SPARams s22", "SENS:TRAC3:SPAR?", "S22"),
        ("CORR OFF", "CORR:STAT?;:SENS:CORR:COLL:STAT:ACC?", "0;0"),
        ("INIT:CONT OFF", "INIT:CONT?", "0"),
    ],
)
def test_settings_are_read_back_in_their_short_form(bench, command, query, answer):
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
        ":CALC1:DATA? FDAT",
        ":?",
    ],
)
def test_unknown_queries_get_no_answer(bench, query):
    outcome = bench.send(query)
    assert (outcome.answer, outcome.fault) == (b"", NetworkFault.NONE)


@each_case(
    "accuracy, interpolated, covers, answers",
    [
        (3, True, 15, "3;15;RF2P;1;1"),
        (0, True, 15, "0;0;;0;0"),
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
        ":SENS:CORR:COLL:STAT:ACC?", ":SENS:CAL:STAT?", ":SENS:CORR:COLL:TYPE?",
        ":SENS:CORR:COLL:INT?", ":CORR:STAT?",
    )  # fmt: skip
    assert ";".join(bench.ask(one) for one in queries) == answers


def test_calibration_at_other_power_is_less_accurate(request):
    bench = new_bench(request, calibration_power=Power.LOW)
    assert bench.ask(":CORR:COLL:STAT:ACC?") == "2"
    bench.send(":SOUR:POW LOW")
    assert bench.ask(":CORR:COLL:STAT:ACC?") == "1"


# Its sweeps and data; time passes only where the test says so.


@pytest.fixture
def timed(request):
    return timed_bench(request)


def test_delayed_setting_reads_back_only_when_it_has_taken_effect(request):
    bench = timed_bench(request, setting_delay_s=2.0)
    bench.clock.advance(3.0)
    assert bench.ask(":SWE:POIN?") == str(POINTS)
    bench.send(":SWE:POIN 77")
    bench.clock.advance(1.9)
    assert bench.ask(":SWE:POIN?") == str(POINTS)
    bench.clock.advance(0.2)
    assert bench.ask(":SWE:POIN?") == "77"


def test_both_formats_have_the_same_numbers(bench):
    binary = real_numbers(swept(bench))
    bench.send("FORM ASC")
    text = ascii_numbers(bench.data()).astype(np.float32)
    assert text.tobytes() == binary.tobytes()


def test_ascii_ends_with_comma_and_newline_unless_told_otherwise(request):
    assert new_bench(request).data().endswith(b",\n")
    bench = new_bench(request, trailing_comma=False, trailing_newline=False, header_digits=8)
    answer = bench.data()
    assert answer.startswith(b"#80000") and answer[-1:].isdigit()
    assert len(ascii_numbers(answer)) == 402


def test_frequencies_are_those_of_the_sweep(bench):
    bench.send("FREQ:STAR 600MHZ;:FREQ:STOP 6GHZ;:SWE:POIN 501")
    expected_hz = np.linspace(600e6, 6e9, 501)
    assert np.array_equal(ascii_numbers(bench.send("FREQ:DATA?").answer), expected_hz)
    bench.send("FORM REAL,32")
    found_hz = real_numbers(bench.send("SENS4:FREQ:DATA?").answer)
    assert found_hz == pytest.approx(expected_hz, abs=256)


def test_preamble_describes_the_sweep(bench):
    bench.send("FREQ:STAR 600MHZ;:SWE:POIN 501;:INIT:CONT OFF;:TRACE1:SPAR S21;:TRACE1:DOM TIME")
    bench.send(":SWE:IFBW 20;:SOUR:POW LOW")
    pairs = bench.preamble()
    expected = {
        "SN": "SIMULATED", "TRACE_1_DSP_DATA_POINTS": "501", "SWEEP_TYPE": "0", "S_TYPE": "1",
        "CAL_CORRECTION": "0", "RF_SOURCE_POWER": "0", "IFBW": "11", "DOMAIN": "1",
    }  # fmt: skip
    assert {name: pairs[name] for name in expected} == expected
    assert float(pairs["TRACE_1_START_FREQ"]) == 600.0
    assert float(pairs["CURRENT_TEMPERATURE"]) / 4.0 == 40.0
    # S21, S12, S21, S22 in four bits each, the first trace in the lowest.
    assert int(pairs["TRACE_S_TYPES"]) == 0x3121
    assert int(pairs["TRACE_DOMAIN_TYPES"]) & 0xF == 1
    bench.send(":SENS:CORR OFF")
    assert bench.preamble()["CAL_CORRECTION"] == "1"


def test_data_replies_are_captured_byte_by_byte(bench):
    data = swept(bench)
    bench.ask("*IDN?")
    frequencies = bench.send("FREQ:DATA?").answer
    assert bench.captured == [("sdat", data), ("freq", frequencies)]


@each_case(
    "commands, gain",
    [
        ("", 1.0),
        (":SWE:IFBW 100", 0.1),
        (":SOUR:POW LOW;:SWE:IFBW 100", 1.0),
    ],
)
def test_noise_follows_bandwidth_and_power(request, commands, gain):
    probe = CountingProbe()
    bench = new_bench(request, medium=probe)
    bench.send(":INIT:CONT OFF")
    bench.send(commands)
    probe.gains.clear()
    swept(bench)
    assert list(probe.gains) == pytest.approx([gain])


def test_bit_can_wait_for_the_whole_average(request):
    bench = timed_bench(request, averaging=Averaging.ALL_SWEEPS)
    bench.send(":AVER:COUN 3")
    for _ in range(2):
        first = bench.sweeper.sweep_number + 1
        bench.send(":INIT:IMM")
        for _sweep in range(3):
            assert bench.ask(":STAT:OPER?") == "0"
            completed = bench.sweeper.sweeps_completed
            bench.clock.advance(SWEEP_S)
            wait_until(lambda n=completed: bench.sweeper.sweeps_completed > n, "end of one sweep")
        bench.wait_for_bit()
        assert bench.preamble()["AVERAGING_COUNT"] == "3"
        # The mean of the three sweeps, none from before the trigger among them.
        assert bench.sweep_numbers() == {first + 1}
