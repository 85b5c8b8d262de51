"""The faults of an analyzer that behaves less kindly, without network."""

from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from vna_bench import SWEEP_S, Bench, new_bench, real_numbers, swept, timed_bench, wait_until

from gpr20_common.faults import NOT_ALLOWED
from gpr20_simulator.faults import FaultError, SceneError
from gpr20_simulator.low.message_device import NetworkFault
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.vna_settings import SETTINGS
from gpr20_simulator.mid.faults import FaultBoard, FaultSwitch, VnaFault
from gpr20_survey.axes.axis_id import AxisId


@pytest.fixture
def bench(request):
    return new_bench(request)


# Which faults are on.


@pytest.fixture
def state(tmp_path):
    return open_shared_state(tmp_path / "state", {axis: 0 for axis in AxisId})


@pytest.fixture
def now_s():
    return [100.0]


@pytest.fixture
def board(now_s):
    return FaultBoard(lambda: now_s[0])


@pytest.fixture
def switch(state, board):
    return FaultSwitch(state, board)


def test_fault_strikes_as_often_as_counted_and_none_switches_all_off(switch, board):
    for fault in VnaFault:
        assert fault.value in str(switch.set("vna", fault.value.lower(), 0))
        assert board.is_permanent(fault)
    switch.set("vna", "none", 0)
    assert board.names() == ""
    switch.set("vna", "truncate", 2)
    assert [board.strikes(VnaFault.TRUNCATE) for _ in range(3)] == [True, True, False]


def test_timed_fault_lasts_as_many_seconds_as_counted(switch, board, now_s):
    noted = []
    board.on_link_gone = lambda: noted.append(1)
    assert "20 s" in str(switch.set("vna", "link_gone", 20))
    assert noted == [1]
    now_s[0] += 19.9
    # However often it strikes meanwhile.
    assert all(board.is_on(VnaFault.LINK_GONE) for _ in range(9))
    now_s[0] += 0.2
    assert not board.is_on(VnaFault.LINK_GONE) and board.names() == ""
    board.set("LINK_GONE", 0)
    now_s[0] += 1e6
    assert board.is_on(VnaFault.LINK_GONE)


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


# What they do.


@each_case(
    "fault, conduct",
    [
        ("HANG", NetworkFault.NO_REPLY),
        ("LINK_GONE", NetworkFault.DROP_CONNECTIONS),
    ],
)
def test_fault_that_stays_hits_new_links_too_until_it_is_cleared(bench, fault, conduct):
    bench.faults.set(fault)
    assert bench.instrument.opened() is conduct
    assert [bench.send("*IDN?").fault for _ in range(3)] == [conduct] * 3
    bench.faults.clear()
    assert bench.instrument.opened() is NetworkFault.NONE
    assert bench.ask("*IDN?").startswith('"Anritsu')


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
def test_fault_spoils_one_answer(bench, fault, spoilt):
    whole = swept(bench, points=101)
    bench.faults.set(fault, 1)
    assert spoilt(bench.data(), whole)
    assert bench.data() == whole


def test_identities_of_others(bench):
    bench.faults.set("WRONG_IDENTITY", 1)
    assert ["Anritsu" in bench.ask("*IDN?") for _ in range(2)] == [False, True]
    bench.faults.set("SWAPPED")
    assert "SIMULATED-2" in bench.ask("*IDN?") and bench.preamble()["SN"] == "SIMULATED-2"
    bench.faults.clear()
    # Another serial number is that of the next connection.
    bench.faults.set("OTHER_SERIAL")
    assert bench.preamble()["SN"] == "SIMULATED"
    bench.instrument.opened()
    assert bench.ask("*IDN?").split(",")[2] == "SIMULATED-2" == bench.preamble()["SN"]
    bench.faults.clear()
    bench.instrument.opened()
    assert bench.preamble()["SN"] == "SIMULATED"


def test_stale_fault_sets_the_bit_and_keeps_the_old_data(bench):
    before = swept(bench)
    bench.faults.set("STALE", 1)
    assert swept(bench) == before
    assert swept(bench) != before


def test_refused_settings_keep_their_value_while_sweeps_go_on(bench):
    bench.faults.set("REFUSE_SETTINGS", 1)
    bench.send("SWE:POIN 77;:FREQ:STAR 1GHZ")
    assert bench.ask("SWE:POIN?;:FREQ:STAR?") == "201;1000000000"
    bench.faults.set("REFUSE_SETTINGS")
    bench.send("SWE:POIN 77;:FREQ:STAR 2GHZ;:FORM REAL,32;:CORR OFF")
    assert bench.ask("SWE:POIN?;:FREQ:STAR?;:FORM?;:CORR?") == "201;1000000000;ASC;1"
    bench.send(":INIT:CONT OFF;:INIT:IMM")
    bench.wait_for_bit()


def test_late_bit_stays_set_after_a_trigger_and_then_tells_the_truth(request):
    bench = timed_bench(request, late_bit_s=1.0, slow_point_s=0.02)
    before = bench.sweep_numbers()
    bench.faults.set("LATE_BIT", 1)
    bench.faults.set("SLOW_POINTS", 1)
    bench.send(":INIT:IMM")
    assert bench.ask(":STAT:OPER?") == "256"
    # Whoever believes it reads points of the sweep before.
    assert bench.sweep_numbers() & before
    bench.clock.advance(1.01)
    assert bench.ask(":STAT:OPER?") == "0"
    # Slow points take longer than configured, once.
    bench.clock.advance(1.1)
    bench.wait_for_bit()
    assert bench.sweep_numbers() == {max(before) + 1}
    bench.sweep()
    # There is none of an unfinished sweep.
    bench.faults.set("LATE_BIT")
    bench.send(":SWE:POIN 55;:INIT:IMM")
    assert bench.ask(":STAT:OPER?") == "0"


def test_display_has_a_sweep_only_some_time_after_its_bit(request):
    bench = timed_bench(request, late_memory_s=0.5)
    before = bench.sweep_numbers()
    bench.faults.set("LATE_MEMORY", 2)
    for _ in range(2):
        bench.sweep()
        assert bench.sweep_numbers() == before
        bench.clock.advance(0.51)
        assert bench.sweep_numbers() == {max(before) + 1}
        before = bench.sweep_numbers()
    bench.sweep()
    assert bench.sweep_numbers() == {max(before) + 1}


def test_unanswered_queries_are_those_of_the_scene(request):
    bench = new_bench(request, unanswered_queries=(":SENS:TRACE1:DOM?", "*IDN?"))
    bench.faults.set("UNANSWERED_QUERY")
    for query in (":SENS:TRACE1:DOM?", ":trac:domain?", "*IDN?"):
        assert bench.send(query).answer == b""
    assert bench.ask(":SENS:TRACE2:DOM?;:SWE:POIN?") == "FREQ;201"
    bench.faults.clear()
    assert bench.ask(":trac:domain?") == "FREQ"
    with pytest.raises(SceneError, match="1234"):
        InstrumentScene(other_serial="1234")


@each_case(
    "command",
    [
        ":FREQ:STAR 1GHZ",
        ":SOUR:POW HIGH",
    ],
)
def test_calibration_is_lost_by_a_write_until_the_fault_is_cleared(bench, command):
    bench.faults.set("LOSES_CALIBRATION", 1)
    bench.send(":SENS:TRACE1:SPAR S21;:AVER:COUN 1;:SWE:POIN?")
    state = ":CORR:COLL:STAT:ACC?;:CORR?;:CAL:STAT?"
    assert bench.ask(state) == "1;1;15"
    bench.send(command)
    bench.send(":CORR ON")
    assert bench.ask(state) == "0;0;0"
    assert bench.preamble()["CAL_CORRECTION"] == "1"
    assert bench.faults.names() == "LOSES_CALIBRATION"
    bench.faults.clear()
    assert bench.ask(state) == "1;1;15"


@each_case(
    "fault, query, before, after",
    [
        ("HAND_BANDWIDTH", ":SWE:IFBW?", "10000", "1000"),
        # Only a sweep that began again shows this.
        ("HAND_PUT_BACK", ":SWE:IFBW?", "10000", "10000"),
    ],
)
def test_setting_is_changed_by_hand_in_mid_sweep(request, fault, query, before, after):
    bench = timed_bench(request)
    bench.faults.set(fault, 1)
    assert bench.ask(query) == before
    number = bench.sweeper.sweep_number + 1
    bench.send(":INIT:IMM")
    bench.clock.advance(0.6 * SWEEP_S)
    wait_until(lambda: bench.sweeper.sweep_number > number and bench.ask(query) == after, "change")
    # A setting that changes restarts the sweep.
    assert bench.ask(":STAT:OPER?") == "0"
    bench.clock.advance(100.0)
    bench.wait_for_bit()
    assert bench.ask(query) == after


# Messages that are none.


@pytest.fixture(scope="module")
def fuzzed():
    one = Bench()
    yield one
    one.stop()


HEADERS = [one.header.pattern.translate(str.maketrans("#", "1", "[]")) for one in SETTINGS]
HEADERS += [":CALC1:DATA", ":TRAC:PRE", ":FREQ:DATA", ":INIT", ":INIT:CONT"]
COMMANDS = st.builds(
    "{}{} {}".format,
    st.sampled_from([*HEADERS, ":STAT:OPER"]),
    st.sampled_from(["", "?"]),
    st.one_of(
        st.sampled_from(["", "ON", "OFF", "SDAT", "FDAT", "S21", "2", "REAL,32", "1GHZ"]),
        st.sampled_from(["1", "A", " ", "?", ":", '"', "\n"]).map(lambda one: one * 150_000 + "X"),
        st.text(max_size=10),
        st.floats().map(str),
    ),
)


@given(st.one_of(st.binary(max_size=60), st.lists(COMMANDS, max_size=4).map(";".join)))
def test_no_message_breaks_the_instrument(fuzzed, message):
    data = message if isinstance(message, bytes) else message.encode("utf-8")
    # A reset takes the instrument off the network, which is what it must do.
    data = data.replace(b"*", b"")
    assert fuzzed.instrument.execute(data).fault is NetworkFault.NONE
    assert fuzzed.ask("*IDN?").startswith('"Anritsu')
    start_hz, stop_hz, points = map(
        float, fuzzed.ask("FREQ:STAR?;:FREQ:STOP?;:SWE:POIN?").split(";")
    )
    assert 5e3 <= start_hz <= stop_hz <= 6e9
    assert 2 <= points <= 4001
