"""Faults of an analyzer that behaves less kindly, seen from its VXI-11 socket."""

from __future__ import annotations

import time

import pytest
import vxi11
from case_kit import each_case
from rpc_wire import LIMIT_S, RawClient, call, record, unpack_words, wait_until, words
from socket_rig import POINT_S, POINTS, Rig
from vxi11_wire import CORE, CoreLink

from gpr20_simulator.errors import SceneError
from gpr20_simulator.low.scaled_clock import ScaledClock
from gpr20_simulator.mid.analyzer.instrument_scene import Averaging, InstrumentScene, Power
from gpr20_simulator.mid.world.medium import probed_sweep

TIME_SCALE = 10.0
SWEEP_S = POINTS * POINT_S / TIME_SCALE


@pytest.fixture
def rig(request):
    return new_rig(request)


def new_rig(request, **description):
    one = Rig(ScaledClock(TIME_SCALE), InstrumentScene(**description), time_scale=TIME_SCALE)
    request.addfinalizer(one.stop)
    one.client.write(":INIT:CONT OFF;:INIT:IMM")
    one.wait_for_sweep()
    return one


def sweep_duration_s(rig):
    started_s = time.monotonic()
    rig.client.write(":INIT:IMM")
    rig.wait_for_sweep()
    return time.monotonic() - started_s


def test_late_bit_stays_set_after_a_trigger_and_then_tells_the_truth(request):
    rig = new_rig(request, late_bit_s=1.0, slow_point_s=0.02)
    before = {probed_sweep(value) for value in rig.data()}
    rig.vna.faults.set("LATE_BIT", 1)
    rig.vna.faults.set("SLOW_POINTS", 1)
    started_s = time.monotonic()
    rig.client.write(":INIT:IMM")
    assert rig.client.ask(":STAT:OPER?") == "256"
    # Whoever believes it reads points of the sweep before.
    assert {probed_sweep(value) for value in rig.data()} & before
    wait_until(lambda: rig.client.ask(":STAT:OPER?") == "0", "clearing of the bit")
    assert time.monotonic() - started_s >= 1.0 / TIME_SCALE
    rig.wait_for_sweep()
    assert {probed_sweep(value) for value in rig.data()} == {max(before) + 1}
    rig.client.write(":INIT:IMM")
    assert rig.client.ask(":STAT:OPER?") == "0"


def test_late_bit_of_an_unfinished_sweep_is_not_set(request):
    rig = new_rig(request, slow_point_s=1.0)
    rig.vna.faults.set("LATE_BIT")
    rig.vna.faults.set("SLOW_POINTS")
    rig.client.write(":SWE:POIN 55;:INIT:IMM")
    assert rig.client.ask(":STAT:OPER?") == "0"
    rig.client.write(":INIT:IMM")
    assert rig.client.ask(":STAT:OPER?") == "0"


def test_slow_points_make_the_sweep_longer_than_configured(rig):
    rig.vna.faults.set("SLOW_POINTS", 1)
    assert sweep_duration_s(rig) >= POINTS * 2e-3 / TIME_SCALE
    assert SWEEP_S <= sweep_duration_s(rig) < POINTS * 2e-3 / TIME_SCALE


@each_case("spelling", [":SENS:TRACE1:DOM?", ":trac:domain?", "SENSE:TRAC1:DOM?"])
def test_unanswered_query_times_out_while_all_else_works(rig, spelling):
    rig.vna.faults.set("UNANSWERED_QUERY")
    rig.client.timeout = 0.2
    with pytest.raises(vxi11.vxi11.Vxi11Exception, match="15"):
        rig.client.ask(spelling)
    rig.client.timeout = LIMIT_S
    assert rig.client.ask(":SENS:TRACE2:DOM?") == "FREQ"
    assert rig.client.ask(":SWE:POIN?") == str(POINTS)
    rig.vna.faults.clear()
    assert rig.client.ask(spelling) == "FREQ"


def test_unanswered_queries_are_those_of_the_scene(request):
    rig = new_rig(request, unanswered_queries=(":INP:GAIN:MODE?", "*IDN?"))
    rig.vna.faults.set("UNANSWERED_QUERY")
    rig.client.timeout = 0.2
    for query in (":INPut:GAIN:MODE?", "*IDN?"):
        with pytest.raises(vxi11.vxi11.Vxi11Exception, match="15"):
            rig.client.ask(query)
    rig.client.timeout = LIMIT_S
    assert rig.client.ask(":SENS:TRACE1:DOM?") == "FREQ"


def test_query_that_the_analyzer_does_not_have_cannot_be_unanswered(request):
    with pytest.raises(SceneError, match="BANANA"):
        new_rig(request, unanswered_queries=(":BANANA?",))


def test_other_serial_is_that_of_the_next_connection(rig):
    rig.vna.faults.set("OTHER_SERIAL")
    assert rig.client.ask("*IDN?").split(",")[2] == "SIMULATED"
    other = rig.connected()
    assert other.ask("*IDN?").split(",")[2] == "SIMULATED-2"
    assert rig.preamble()["SN"] == "SIMULATED-2"
    rig.vna.faults.clear()
    assert rig.connected().ask("*IDN?").split(",")[2] == "SIMULATED"


def test_other_serial_says_that_it_is_simulated():
    with pytest.raises(SceneError, match="1234"):
        InstrumentScene(other_serial="1234")


def assert_unreachable(rig):
    with pytest.raises((EOFError, OSError)):
        rig.client.ask("*IDN?")
    with pytest.raises((EOFError, OSError)):
        CoreLink(rig.vna.server.port)
    with RawClient(rig.vna.server.port) as client:
        assert client.is_closed()


def test_link_is_gone_until_the_fault_is_cleared(rig):
    rig.vna.faults.set("LINK_GONE")
    assert rig.client.client.sock.recv(1) == b""
    assert_unreachable(rig)
    assert rig.vna.faults.names() == "LINK_GONE"
    rig.vna.faults.clear()
    assert rig.connected().ask("*IDN?").startswith('"Anritsu')


def test_link_is_gone_for_as_many_real_seconds_as_counted(rig):
    started_s = time.monotonic()
    rig.vna.faults.set("LINK_GONE", 1)
    assert_unreachable(rig)

    def is_back():
        try:
            return rig.connected().ask("*IDN?").startswith('"Anritsu')
        except (EOFError, OSError):
            return False

    wait_until(is_back, "return of the link")
    assert time.monotonic() - started_s >= 1.0
    assert rig.vna.faults.names() == ""


@each_case(
    "command",
    [
        ":FREQ:STAR 1GHZ",
        ":FREQ:STOP 6GHZ",
        ":SWE:POIN 401",
        ":SWE:IFBW 1000",
        ":SOUR:POW HIGH",
        ":FREQ:CENT 3GHZ",
        ":FREQ:SPAN 1GHZ",
    ],
)
def test_calibration_is_lost_by_a_write_until_the_fault_is_cleared(rig, command):
    rig.vna.faults.set("LOSES_CALIBRATION", 1)
    rig.client.write(":SENS:TRACE1:SPAR S21;:CALC1:FORM SMIT;:AVER:COUN 1;:SWE:POIN?")
    assert rig.client.read() == str(POINTS)
    accuracy = ":CORR:COLL:STAT:ACC?"
    assert rig.client.ask(accuracy) == "1"
    rig.client.write(command)
    rig.client.write(":CORR ON")
    state = (accuracy, ":CORR?", ":CAL:STAT?", ":CORR:COLL:STAT?")
    assert [rig.client.ask(one) for one in state] == ["0"] * 4
    assert rig.preamble()["CAL_CORRECTION"] == "1"
    assert rig.vna.faults.names() == "LOSES_CALIBRATION"
    rig.vna.faults.clear()
    assert [rig.client.ask(one) for one in state] == ["1", "1", "15", "4"]


def test_endless_digits_replace_numbers_alone(rig):
    rig.vna.faults.set("ENDLESS_DIGITS")
    for query in (":SENS:FREQ:STAR?", ":SWE:POIN?", ":STAT:OPER?"):
        answer = rig.client.ask(query)
        assert answer[:-1].isdigit()
        assert len(answer) == 40_001
        assert answer[-1] == "X"
    assert rig.client.ask("*IDN?").startswith('"Anritsu')
    assert rig.client.ask(":SENS:TRACE1:SPAR?") == "S21"
    assert len(rig.data()) == POINTS


def test_no_clear_is_an_unknown_procedure(rig):
    rig.vna.faults.set("NO_CLEAR", 1)
    with CoreLink(rig.vna.server.port) as link:
        link.send(record(call(CORE, 1, 15, words(link.link, 0, 0, 0))))
        assert unpack_words(link.reply())[5] == 3
        assert link.generic(15) == (0,)


def test_clear_can_be_unsupported(rig):
    rig.vna.faults.set("CLEAR_UNSUPPORTED", 1)
    with CoreLink(rig.vna.server.port) as link:
        assert link.generic(15) == (8,)
        assert link.generic(15) == (0,)


@pytest.mark.parametrize(
    "fault, query, before, after",
    [
        ("HAND_BANDWIDTH", ":SWE:IFBW?", "10000", "1000"),
        ("HAND_AVERAGES", ":AVER:COUN?", "1", "4"),
        ("HAND_POWER", ":SOUR:POW?", "HIGH", "LOW"),
        ("HAND_START", ":FREQ:STAR?", "600000000", "601000000"),
    ],
)
def test_setting_is_changed_by_hand_in_mid_sweep(rig, fault, query, before, after):
    rig.vna.faults.set(fault, 1)
    assert rig.client.ask(query) == before
    duration_s = sweep_duration_s(rig)
    assert rig.client.ask(query) == after
    # A setting that changes restarts the sweep.
    assert duration_s >= 1.4 * SWEEP_S
    assert sweep_duration_s(rig) < 10 * SWEEP_S
    assert rig.client.ask(query) == after
    rig.vna.faults.set(fault, 1)
    sweep_duration_s(rig)
    assert rig.client.ask(query) != after


def test_narrow_bandwidth_takes_its_time(request):
    rig = Rig(ScaledClock(200.0), time_scale=200.0)
    request.addfinalizer(rig.stop)
    rig.client.write(":INIT:CONT OFF;:SWE:POIN 501;:SWE:IFBW 20")
    duration_s = sweep_duration_s(rig) * 200.0
    assert 35.0 <= duration_s < 60.0


def test_preamble_tells_average_bandwidth_and_power(rig):
    rig.client.write(":AVER:COUN 3;:SWE:IFBW 20;:SOUR:POW LOW;:SWE:POIN 2;:INIT:IMM")
    rig.wait_for_sweep()
    found = rig.preamble()
    assert (found["AVERAGING_COUNT"], found["AVERAGING_FACTOR"]) == ("1", "3")
    assert (found["IFBW"], found["RF_SOURCE_POWER"]) == ("11", "0")


def test_average_rolls_over_triggers_by_default(rig):
    rig.client.write(":AVER:COUN 3")
    for expected in ("1", "2", "3", "3"):
        assert sweep_duration_s(rig) >= SWEEP_S
        assert rig.preamble()["AVERAGING_COUNT"] == expected


def test_bit_can_wait_for_the_whole_average(request):
    rig = new_rig(request, averaging=Averaging.ALL_SWEEPS)
    rig.client.write(":AVER:COUN 3")
    for _ in range(2):
        first = rig.vna.sweeper.sweep_number + 1
        assert sweep_duration_s(rig) >= 3 * SWEEP_S
        assert rig.preamble()["AVERAGING_COUNT"] == "3"
        # The mean of the three sweeps, none from before the trigger among them.
        assert {probed_sweep(value) for value in rig.data()} == {first + 1}


def test_calibration_at_other_power_is_less_accurate(request):
    rig = new_rig(request, calibration_power=Power.LOW)
    assert rig.client.ask(":CORR:COLL:STAT:ACC?") == "2"
    rig.client.write(":SOUR:POW LOW")
    assert rig.client.ask(":CORR:COLL:STAT:ACC?") == "1"


def test_each_message_takes_its_time(request):
    rig = new_rig(request, message_s=0.03)
    started_s = time.monotonic()
    rig.client.write(":SWE:POIN 11")
    assert time.monotonic() - started_s >= 0.03
    assert rig.client.ask(":SWE:POIN?") == "11"
    # In real seconds, whatever the time scale; reading takes none.
    assert 0.06 <= time.monotonic() - started_s < 1.0


def test_local_state_and_continuous_sweeps_after_release_can_be_seen(rig):
    assert rig.vna.instrument.is_remote
    assert not rig.vna.sweeper.is_continuous
    rig.client.write(":INIT:CONT ON")
    rig.client.local()
    assert not rig.vna.instrument.is_remote
    assert rig.vna.sweeper.is_continuous
    rig.client.remote()
    assert rig.vna.instrument.is_remote


def test_message_of_thousands_of_queries_is_answered_whole(rig):
    queries = b";".join([b":SWE:POIN?"] * 3500)
    assert rig.client.ask_raw(queries) == b";".join([b"401"] * 3500) + b"\n"
    assert rig.client.ask("*IDN?").startswith('"Anritsu')


def test_answers_of_one_message_are_bounded(rig):
    rig.client.write(":SWE:POIN 4001;:FORM ASC")
    answer = rig.client.ask_raw(b";".join([b":CALC1:DATA? SDAT"] * 3500))
    # The answer that passes the limit is still given.
    assert (1 << 20) <= len(answer) < (1 << 20) + 200_000
    assert rig.client.ask("*IDN?").startswith('"Anritsu')
