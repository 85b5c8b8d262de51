"""The whole analyzer through a real VXI-11 socket, with its sweep time."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest
import pyvisa
import vxi11
from case_kit import each_case
from rpc_wire import RawClient, wait_until
from socket_rig import POINT_S, POINTS, SWEEP_S, Rig
from vna_bench import ascii_numbers

from gpr20_common.errors import InvalidValueError
from gpr20_simulator.errors import MediumError
from gpr20_simulator.low.scaled_clock import ScaledClock
from gpr20_simulator.mid.analyzer.simulated_analyzer import (
    AnalyzerOptions,
    medium_by_name,
)
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import PositionProbe, probed_position_mm, probed_sweep
from gpr20_simulator.mid.world.scene import Scene


@pytest.fixture
def rig():
    one = Rig()
    yield one
    one.stop()


def test_triggered_sweep_holds_points_of_that_sweep_alone(rig):
    rig.client.write(":INIT:CONT OFF")
    numbers = []
    for _ in range(3):
        started_s = time.monotonic()
        rig.client.write(":INIT:IMM")
        rig.wait_for_sweep()
        assert time.monotonic() - started_s >= SWEEP_S
        sweeps = {probed_sweep(value) for value in rig.data()}
        assert len(sweeps) == 1
        numbers += sweeps
    assert numbers == [numbers[0], numbers[0] + 1, numbers[0] + 2]


def test_continuous_sweeps_keep_counting(rig):
    assert rig.client.ask(":INIT:CONT?") == "1"
    seen = set()

    def has_counted_on():
        numbers = [probed_sweep(value) for value in rig.data()]
        # What the display holds: the newest points first, the rest from the sweep before.
        assert numbers == sorted(numbers, reverse=True)
        seen.update(numbers)
        return len(seen) >= 4

    wait_until(has_counted_on, "three more sweeps")


def test_sweep_after_a_move_sees_the_end_of_the_move_alone(rig):
    rig.client.write(":INIT:CONT OFF")
    rig.carriage.move(123.0, 45.0)
    rig.client.write(":INIT:IMM")
    rig.wait_for_sweep()
    assert {probed_position_mm(value) for value in rig.data()} == {(123, 45)}


def test_faster_clock_makes_faster_sweeps():
    rig = Rig(ScaledClock(20.0), time_scale=20.0)
    rig.client.write(":INIT:CONT OFF;:SWE:POIN 4001")
    started_s = time.monotonic()
    rig.client.write(":INIT:IMM")
    rig.wait_for_sweep()
    duration_s = time.monotonic() - started_s
    rig.stop()
    assert 4001 * POINT_S / 20.0 <= duration_s < 4001 * POINT_S


def test_longest_ascii_reply_comes_whole(rig):
    rig.client.write(":INIT:CONT OFF;:FORM ASC;:SWE:POIN 4001")
    answer = rig.client.ask_raw(b":CALC1:DATA? SDAT")
    assert len(ascii_numbers(answer)) == 2 * 4001


def test_pyvisa_reads_a_trace(rig):
    manager = pyvisa.ResourceManager("@py")
    address = f"TCPIP::127.0.0.1,{rig.vna.server.port}::inst0::INSTR"
    with manager.open_resource(address) as resource:
        assert resource.query("*IDN?").startswith('"Anritsu,MS2026C/2,SIMULATED')
        values = resource.query_binary_values(":CALC1:DATA? SDAT", container=np.array)
        assert len(values) == 2 * POINTS


def test_late_answer_puts_a_careless_client_out_of_step(rig):
    rig.vna.faults.set("LATE", 1)
    rig.client.timeout = 0.05
    with pytest.raises(vxi11.vxi11.Vxi11Exception, match="15"):
        rig.client.ask(":SWE:POIN?")
    assert rig.client.ask("*IDN?") == str(POINTS)
    rig.client.clear()
    assert rig.client.ask("*IDN?").startswith('"Anritsu')


def test_reset_makes_the_instrument_vanish(rig):
    with pytest.raises((EOFError, OSError)):
        rig.client.ask("*RST")
    assert rig.vna.instrument.network_lost
    with pytest.raises(ConnectionRefusedError):
        RawClient(rig.vna.server.port)


def test_stopped_analyzer_leaves_no_thread():
    before = set(threading.enumerate())
    rig = Rig()
    rig.stop()
    wait_until(lambda: set(threading.enumerate()) <= before, "end of all threads")


@each_case(
    "options", [{"seconds_per_point": -1.0}, {"seconds_per_point": float("nan")}, {"port": 70000}]
)
def test_options_out_of_range_are_refused(options):
    with pytest.raises(InvalidValueError, match=next(iter(options))):
        AnalyzerOptions(**options)


def test_media_are_chosen_by_name():
    assert isinstance(medium_by_name("scene", Scene()), Ground)
    assert isinstance(medium_by_name("position_probe", Scene()), PositionProbe)
    with pytest.raises(MediumError, match="position_probe"):
        medium_by_name("air", Scene())
