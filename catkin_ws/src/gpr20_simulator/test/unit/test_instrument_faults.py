"""The instrument's faults, and messages that are none, without network."""

from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from rpc_wire import wait_until
from vna_bench import (
    Bench,
    ascii_numbers,
    real_numbers,
    swept,
)

from gpr20_simulator.errors import FaultError
from gpr20_simulator.faults import UNKNOWN_FAULT
from gpr20_simulator.low.message_device import NetworkFault
from gpr20_simulator.mid.analyzer.scpi import HeaderPattern
from gpr20_simulator.mid.analyzer.vna_commands import SETTINGS
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard


def test_hang_gets_no_reply_for_as_many_messages_as_counted(bench):
    bench.faults.set("hang", 2)
    conducts = [bench.send("*IDN?").fault for _ in range(3)]
    assert conducts == [NetworkFault.NO_REPLY, NetworkFault.NO_REPLY, NetworkFault.NONE]
    assert bench.instrument.opened() is NetworkFault.NONE


@each_case(
    "fault, conduct", [("HANG", NetworkFault.NO_REPLY), ("DROP", NetworkFault.DROP_CONNECTIONS)]
)
def test_fault_that_stays_hits_new_links_too_until_it_is_cleared(bench, fault, conduct):
    bench.faults.set(fault)
    assert bench.instrument.opened() is conduct
    assert [bench.send("*IDN?").fault for _ in range(5)] == [conduct] * 5
    bench.faults.clear()
    assert bench.instrument.opened() is NetworkFault.NONE
    assert bench.ask("*IDN?").startswith('"Anritsu')


def test_silent_fault_keeps_answers_back(bench):
    bench.faults.set("SILENT", 1)
    assert bench.send("*IDN?").answer == b""
    assert bench.send("*IDN?").answer != b""


@each_case("data_format", ["ASC", "REAL,32"])
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


@each_case("name, count, shown", [("EXPLODE", 0, "HANG"), ("", 0, "HANG"), ("HANG", -1, 0)])
def test_unknown_fault_is_refused_with_what_is_allowed(name, count, shown):
    with raises_fault(UNKNOWN_FAULT, shown, error=FaultError):
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


@given(st.one_of(st.binary(max_size=60), st.lists(COMMANDS, max_size=4).map(";".join)))
def test_no_message_breaks_the_instrument(fuzzed, message):
    data = message if isinstance(message, bytes) else message.encode("utf-8")
    if b"*RST" in data.upper():
        return
    assert fuzzed.instrument.execute(data).fault is NetworkFault.NONE
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
