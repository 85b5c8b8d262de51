"""What the instrument understands, what it says of itself, and its faults, without network.

After the programming manual of the MS20xxC (Anritsu 10580-00306).
"""

from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from vna_bench import POINTS, SWEEP_S, Bench, ascii_numbers, real_numbers

from gpr20_common.faults import NOT_ALLOWED
from gpr20_simulator.low.message_device import NetworkFault
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.analyzer.vna_settings import SETTINGS
from gpr20_simulator.mid.faults import FaultBoard, FaultError, FaultSwitch, SceneError, VnaFault
from gpr20_simulator.mid.world.scene import InstrumentScene
from gpr20_survey.axes import AxisId


@pytest.fixture
def bench():
    return Bench()


# The language and the settings.


@each_case(
    "command, query, answer",
    [
        ("FREQ:STAR 600000000", "FREQ:STAR?", "600000000"),
        ("  FREQ:STAR 6e8 ;:SWE:POIN 2\r\n", ":sense:FREQuency:start?", "600000000"),
        # A later command needs its colon.
        ("SWE:POIN 77;SWE:POIN 78", "SWE:POIN?", "77"),
        ("FREQ:STOP 1E9;:FREQ:STAR 2E9", "FREQ:STAR?;:FREQ:STOP?", "2000000000;2000000000"),
        ("SWE:POIN 4001", "SWE:POIN?", "4001"),
        ("FORMAT:READINGS:DATA REAL, 32", "FORM:DATA?", "REAL,32"),
        ("TRAC3:SPARams s22", "SENS:TRAC3:SPAR?", "S22"),
        ("CORR OFF", "CORR:STAT?;:SENS:CORR:COLL:STAT:ACC?", "0;0"),
        # Who is refused keeps the former value, without a word.
        ("FREQ:STAR 4999", "FREQ:STAR?", "5000"),
        ("FREQU:STAR 1E9", "FREQ:STAR?", "5000"),
        ("SWE:POIN 4002", "SWE:POIN?", str(POINTS)),
        ("SWE:IFBW 30000", "SWE:IFBW?", "10000"),
        ("AVER:COUN 0", "AVER:COUN?", "1"),
        ("TRAC1:SPAR S31", "TRAC1:SPAR?", "S21"),
    ],
)
def test_settings_are_read_back_in_their_short_form(command, query, answer):
    bench = Bench()
    assert bench.send(command).answer == b""
    assert bench.ask(query) == answer


@each_case("query", ["*OPC?", ":CALC9:DATA? SDAT", ":CALC1:DATA? FDAT", ":?"])
def test_unknown_queries_get_no_answer(query):
    outcome = Bench().send(query)
    assert (outcome.answer, outcome.fault) == (b"", NetworkFault.NONE)


def test_identity_and_calibration_are_those_of_the_scene(bench):
    assert bench.send("*IDN?").answer == b'"Anritsu,MS2026C/2,SIMULATED,1.23"\n'
    states = ":SENS:CORR:COLL:STAT:ACC?;:SENS:CAL:STAT?;:CORR:STAT?"
    other = Bench(model="MS2036C/2", serial="SIMULATED-1", calibration_accuracy=3)
    assert other.ask("*idn?\r\n") == '"Anritsu,MS2036C/2,SIMULATED-1,1.23"'
    assert other.ask(states) == "3;15;1"
    # Without a calibration there is no correction.
    other = Bench(calibration_accuracy=0)
    other.send(":CORR ON")
    assert other.ask(states) == "0;0;0"
    with pytest.raises(SceneError, match="1234"):
        InstrumentScene(other_serial="1234")


def test_a_delayed_setting_reads_back_only_when_it_has_taken_effect():
    bench = Bench(setting_delay_s=2.0)
    bench.send(":SWE:POIN 77")
    bench.pass_s(1.9)
    assert bench.ask(":SWE:POIN?") == str(POINTS)
    bench.pass_s(0.2)
    assert bench.ask(":SWE:POIN?") == "77"


# Data.


def test_both_formats_have_the_same_numbers_and_are_captured_byte_by_byte(bench):
    binary = bench.sweep()
    bench.send("FORM ASC")
    text = bench.data()
    assert text.endswith(b",\n")
    assert ascii_numbers(text).astype(np.float32).tobytes() == real_numbers(binary).tobytes()
    assert bench.sent["sdat"][-2:] == [binary, text]


def test_preamble_describes_the_sweep(bench):
    bench.send("FREQ:STAR 6E8;:SWE:POIN 501;:TRACE1:DOM TIME;:SWE:IFBW 20;:SOUR:POW LOW")
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
    bench.send(":SENS:CORR OFF")
    assert bench.preamble()["CAL_CORRECTION"] == "1"


# Faults.


@pytest.fixture
def now_s():
    return [100.0]


@pytest.fixture
def board(now_s):
    return FaultBoard(lambda: now_s[0])


@pytest.fixture
def switch(tmp_path, board):
    return FaultSwitch(open_shared_state(tmp_path / "state", {axis: 0 for axis in AxisId}), board)


def test_a_fault_strikes_as_often_as_counted_and_none_switches_all_off(switch, board):
    for fault in VnaFault:
        assert fault.value in str(switch.set("vna", fault.value.lower(), 0))
        assert board.is_permanent(fault)
    switch.set("vna", "none", 0)
    assert board.names() == ""
    switch.set("vna", "truncate", 2)
    assert [board.strikes(VnaFault.TRUNCATE) for _ in range(3)] == [True, True, False]


def test_a_timed_fault_lasts_as_many_seconds_as_counted(switch, board, now_s):
    noted = []
    board.on_link_gone = lambda: noted.append(1)
    assert "20 s" in str(switch.set("vna", "link_gone", 20))
    assert noted == [1]
    now_s[0] += 19.9
    # However often it strikes meanwhile.
    assert all(board.is_on(VnaFault.LINK_GONE) for _ in range(9))
    now_s[0] += 0.2
    assert not board.is_on(VnaFault.LINK_GONE) and board.names() == ""


@each_case(
    "device, fault, count, shown",
    [
        ("gpu", "HANG", 0, ("'gpu'", "vna, endstop_x, endstop_y, adc")),
        ("vna", "STUCK", 0, ("'STUCK'", "NONE, HANG")),
        ("adc", "STUCK", 3, (3,)),
    ],
)
def test_what_does_not_exist_is_refused_with_what_does(switch, device, fault, count, shown):
    with raises_fault(NOT_ALLOWED, *shown, error=FaultError):
        switch.set(device, fault, count)
    assert switch.names() == ""


def test_late_answer_and_reset_are_orders_to_the_network(bench):
    bench.faults.set("LATE", 1)
    found = [bench.send("*IDN?").fault for _ in range(2)]
    assert found == [NetworkFault.ANSWER_LATE, NetworkFault.NONE]
    # A reset makes the instrument vanish.
    assert bench.send("*RST").fault is NetworkFault.DROP_CONNECTIONS
    assert not bench.instrument.is_reachable()


@each_case(
    "fault, spoilt",
    [
        ("SILENT", lambda answer, whole: answer == b""),
        ("TRUNCATE", lambda answer, whole: answer == whole[:-10] + b"\n"),
        ("NAN", lambda answer, whole: 0 < np.isnan(real_numbers(answer)).sum() < 20),
        ("GARBAGE", lambda answer, whole: len(answer) == len(whole) and answer != whole),
    ],
)
def test_a_fault_spoils_one_answer(fault, spoilt):
    bench = Bench()
    whole = bench.data()
    bench.faults.set(fault, 1)
    assert spoilt(bench.data(), whole)
    assert bench.data() == whole


def test_a_stale_sweep_sets_the_bit_and_keeps_the_old_data(bench):
    before = bench.sweep()
    bench.faults.set("STALE", 1)
    assert bench.sweep() == before
    assert bench.sweep() != before


def test_a_late_bit_stays_set_after_a_trigger_and_then_says_the_truth():
    bench = Bench(late_bit_s=1.0, slow_point_s=0.02)
    bench.faults.set("LATE_BIT", 1)
    bench.faults.set("SLOW_POINTS", 1)
    before = bench.sweeps()[0]
    bench.send(":INIT:IMM")
    assert bench.ask(":STAT:OPER?") == "256"
    # Whoever believes it reads points of the sweep before.
    assert before in bench.sweeps()
    bench.pass_s(1.01)
    assert bench.ask(":STAT:OPER?") == "0"
    # Slow points take longer than configured, once.
    bench.pass_s(1.1)
    assert bench.ask(":STAT:OPER?") == "256" and set(bench.sweeps()) == {before + 1}
    bench.sweep()


def test_a_late_display_shows_the_sweep_before_until_it_is_due():
    bench = Bench(late_memory_s=0.5)
    before = bench.sweeps()[0]
    bench.faults.set("LATE_MEMORY", 1)
    bench.sweep()
    assert set(bench.sweeps()) == {before}
    bench.pass_s(0.5)
    assert set(bench.sweeps()) == {before + 1}


def test_a_setting_is_changed_by_hand_in_mid_sweep_and_restarts_it(bench):
    bench.faults.set("HAND_BANDWIDTH", 1)
    assert bench.ask(":SWE:IFBW?") == "10000"
    number = bench.sweeper.sweep_number
    bench.send(":INIT:IMM")
    bench.pass_s(0.6 * SWEEP_S)
    assert bench.ask(":SWE:IFBW?") == "1000" and bench.sweeper.sweep_number == number + 2
    bench.faults.set("REFUSE_SETTINGS")
    bench.send("SWE:POIN 77;:FREQ:STAR 2E9")
    assert bench.ask("SWE:POIN?;:FREQ:STAR?") == f"{POINTS};5000"


# Messages that are none.

HEADERS = [one.header.pattern.translate(str.maketrans("#", "1", "[]")) for one in SETTINGS]
HEADERS += [":CALC1:DATA", ":TRAC:PRE", ":FREQ:DATA", ":INIT", ":INIT:CONT"]
COMMANDS = st.builds(
    "{}{} {}".format,
    st.sampled_from([*HEADERS, ":STAT:OPER"]),
    st.sampled_from(["", "?"]),
    st.one_of(
        st.sampled_from(["", "ON", "OFF", "SDAT", "FDAT", "S21", "2", "REAL,32", "1E9"]),
        st.sampled_from(["1", "A", " ", "?", ":", '"', "\n"]).map(lambda one: one * 150_000 + "X"),
        st.text(max_size=10),
        st.floats().map(str),
    ),
)
FUZZED = Bench()


@given(st.one_of(st.binary(max_size=60), st.lists(COMMANDS, max_size=4).map(";".join)))
def test_no_message_breaks_the_instrument(message):
    data = message if isinstance(message, bytes) else message.encode("utf-8")
    # A reset takes the instrument off the network, which is what it must do.
    data = data.replace(b"*", b"")
    assert FUZZED.send(data).fault is NetworkFault.NONE
    assert FUZZED.ask("*IDN?").startswith('"Anritsu')
    start_hz, stop_hz, points = map(
        float, FUZZED.ask("FREQ:STAR?;:FREQ:STOP?;:SWE:POIN?").split(";")
    )
    assert 5e3 <= start_hz <= stop_hz <= 6e9
    assert 2 <= points <= 4001
