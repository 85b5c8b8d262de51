"""The instrument's sweeps and data, without network; sweeps take no time unless said."""

from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case
from rpc_wire import wait_until
from vna_bench import (
    HandClock,
    ascii_numbers,
    block_content,
    new_bench,
    real_numbers,
    swept,
)

from gpr20_simulator.mid.world.medium import PositionProbe


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


def preamble(bench):
    content = block_content(bench.send("TRAC:PRE?").answer).decode()
    return dict(pair.split("=") for pair in content.split(","))


def test_preamble_describes_the_sweep(bench):
    bench.send("FREQ:STAR 600MHZ;:SWE:POIN 501;:SWE:TYPE SING;:TRACE1:SPAR S21;:TRACE1:DOM TIME")
    pairs = preamble(bench)
    assert pairs["SN"] == "SIMULATED"
    assert float(pairs["TRACE_1_START_FREQ"]) == 600.0
    assert pairs["TRACE_1_DSP_DATA_POINTS"] == "501"
    assert (pairs["SWEEP_TYPE"], pairs["CAL_CORRECTION"], pairs["RF_SOURCE_POWER"]) == (
        "0",
        "0",
        "1",
    )
    assert float(pairs["CURRENT_TEMPERATURE"]) / 4.0 == 40.0
    # S21, S12, S21, S22 in four bits each, the first trace in the lowest.
    assert int(pairs["TRACE_S_TYPES"]) == 0x3121 and pairs["S_TYPE"] == "1"
    assert pairs["DOMAIN"] == "1" and int(pairs["TRACE_DOMAIN_TYPES"]) & 0xF == 1
    bench.send(":SENS:CORR OFF")
    assert preamble(bench)["CAL_CORRECTION"] == "1"


def test_another_unit_can_answer_on_the_same_link(bench):
    bench.faults.set("SWAPPED")
    assert "SIMULATED-2" in bench.ask("*IDN?") and preamble(bench)["SN"] == "SIMULATED-2"
    bench.faults.clear()
    assert preamble(bench)["SN"] == "SIMULATED"


def test_calibration_says_what_it_covers(request):
    covers = new_bench(request, calibrated_parameters=1, calibration_interpolated=True)
    asked = (":SENS:CAL:STAT?", ":SENS:CORR:COLL:TYPE?", ":SENS:CORR:COLL:INT?")
    assert [covers.ask(one) for one in asked] == ["1", "RF2P", "1"]
    none = new_bench(request, calibration_accuracy=0, calibration_interpolated=True)
    assert [none.ask(one) for one in asked] == ["0", "", "0"]


def test_display_has_a_sweep_only_some_time_after_its_bit(request):
    clock = HandClock()
    bench = new_bench(request, clock=clock, seconds_per_point=0.001, late_memory_s=0.5)
    bench.send(":INIT:CONT OFF;:SWE:POIN 11;:SENS:TRACE1:SPAR S21;:FORM REAL,32")
    bench.faults.set("LATE_MEMORY", 2)

    def sweep():
        bench.send(":INIT:IMM")
        clock.advance(0.1)
        wait_until(lambda: bench.ask(":STAT:OPER?") == "256", "end of the sweep")
        return data()

    def data():
        return bench.send(":CALC1:DATA? SDAT").answer

    before = data()
    assert sweep() == before
    clock.advance(0.51)
    first = data()
    assert first != before
    assert sweep() == first
    clock.advance(0.51)
    assert data() != first
    # The fault has struck twice.
    last = data()
    assert sweep() != last


def test_hand_that_puts_a_setting_back_begins_the_sweep_again_and_leaves_no_other_trace(request):
    clock = HandClock()
    bench = new_bench(request, clock=clock, seconds_per_point=0.001)
    bench.send(":INIT:CONT OFF;:SWE:POIN 101")
    before = preamble(bench)
    bench.faults.set("HAND_PUT_BACK", 1)
    bench.send(":INIT:IMM")
    numbers = [bench.sweeper.sweep_number]
    clock.advance(0.06)
    wait_until(lambda: bench.sweeper.sweep_number == numbers[0] + 2, "both restarts")
    clock.advance(0.2)
    wait_until(lambda: bench.ask(":STAT:OPER?") == "256", "end of the sweep")
    now = preamble(bench)
    assert {one for one in now if now[one] != before[one]} <= {"AVERAGING_COUNT"}


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
        (":SWE:IFBW 100000", 10.0**0.5),
        (":SOUR:POW LOW", 10.0),
        (":SOUR:POW LOW;:SWE:IFBW 100", 1.0),
    ],
)
def test_noise_follows_bandwidth_and_power(request, commands, gain):
    gains = set()

    class GainProbe(PositionProbe):
        def s21(self, frequency_hz, position, sweep_number, noise_gain=1.0):
            gains.add(noise_gain)
            return super().s21(frequency_hz, position, sweep_number, noise_gain)

    bench = new_bench(request, medium=GainProbe())
    bench.send(":INIT:CONT OFF")
    bench.send(commands)
    gains.clear()
    swept(bench)
    assert list(gains) == pytest.approx([gain])


def test_end_of_a_hold_is_a_trigger_with_its_faults(request):
    clock = HandClock()
    bench = new_bench(request, clock=clock, seconds_per_point=0.001)
    bench.send(":INIT:CONT OFF;:INIT:IMM")
    clock.advance(1.0)
    wait_until(lambda: bench.ask(":STAT:OPER?") == "256", "end of the sweep")
    bench.faults.set("LATE_BIT", 1)
    bench.send(":INIT:HOLD OFF")
    assert bench.ask(":STAT:OPER?") == "256"
    clock.advance(0.31)
    bench.send(":INIT:HOLD ON;:INIT:HOLD OFF")
    assert bench.ask(":STAT:OPER?") == "0"
