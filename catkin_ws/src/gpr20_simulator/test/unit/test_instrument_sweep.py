"""The instrument's sweeps and data, without network; time passes only where the test says so."""

from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case
from vna_bench import (
    POINTS,
    SWEEP_S,
    CountingProbe,
    ascii_numbers,
    block_content,
    new_bench,
    real_numbers,
    swept,
    timed_bench,
)
from vxi11_wire import wait_until

from gpr20_simulator.mid.analyzer.instrument_scene import Averaging


@pytest.fixture
def bench(request):
    return new_bench(request)


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
    bench.send(":SWE:POIN 99;:SYST:PRES")
    bench.clock.advance(3.0)
    assert bench.ask(":SWE:POIN?") == "201"


def test_all_formats_have_the_same_numbers(bench):
    binary = real_numbers(swept(bench))
    bench.send("FORM ASC")
    text = ascii_numbers(bench.data()).astype(np.float32)
    assert text.tobytes() == binary.tobytes()
    assert bench.send(":TRAC? 1").answer == bench.data()
    bench.send("FORM INT,32")
    steps = np.frombuffer(block_content(bench.data()), "<i4")
    assert steps == pytest.approx(binary * 1e6, abs=1.0)


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
    bench.send("FREQ:STAR 600MHZ;:SWE:POIN 501;:SWE:TYPE SING;:TRACE1:SPAR S21;:TRACE1:DOM TIME")
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


def test_answers_of_one_message_are_bounded(bench):
    assert bench.ask(";".join([":SWE:POIN?"] * 3500)) == ";".join(["201"] * 3500)
    bench.send(":SWE:POIN 4001;:FORM ASC")
    answer = bench.send(";".join([":CALC1:DATA? SDAT"] * 3500)).answer
    # The answer that passes the limit is still given.
    assert (1 << 20) <= len(answer) < (1 << 20) + 200_000
