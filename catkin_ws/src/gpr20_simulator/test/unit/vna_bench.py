"""A simulated analyzer on the bench: probe medium, movable antennas, real or hand-driven clock."""

from __future__ import annotations

import threading

import numpy as np
from rpc_wire import wait_until

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.instrument import SimulatedVna
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.sweep_plan import SweepPace
from gpr20_simulator.mid.analyzer.sweeper import Sweeper
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard
from gpr20_simulator.mid.analyzer.vna_settings import VnaSettings
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe


class HandClock(Clock):
    """Time passes only when the test says so."""

    def __init__(self):
        self._now_s = 1000.0
        self._moved = threading.Event()

    def now_s(self):
        return self._now_s

    def advance(self, seconds):
        self._now_s += seconds

    def wait_s(self, event, timeout_s):
        # Short, because the test may advance the time at any moment.
        return event.wait(min(timeout_s, 0.001))


class CountingProbe(PositionProbe):
    """Counts how often it is measured."""

    def __init__(self):
        self.calls = 0

    def s21(self, frequency_hz, position, sweep_number, noise_gain=1.0):
        self.calls += 1
        return super().s21(frequency_hz, position, sweep_number, noise_gain)


class Carriage:
    """Antennas that are where the test put them; counts who looks where they are."""

    def __init__(self):
        self.here = AntennaPosition(0.0, 0.0, 0.0)
        self.looks = 0

    def move(self, x_mm, y_mm=0.0, rotation_deg=0.0):
        self.here = AntennaPosition(x_mm, y_mm, rotation_deg)

    def position(self):
        self.looks += 1
        return self.here


class Bench:
    """An instrument without network."""

    def __init__(self, clock=None, seconds_per_point=0.0, medium=None, **description):
        self.carriage = Carriage()
        self.faults = FaultBoard()
        self.captured = []
        plan = VnaSettings().plan(seconds_per_point)
        clock = clock or Clock()
        self.sweeper = Sweeper(
            medium or PositionProbe(), self.carriage.position, clock, plan, SweepPace()
        )
        self.instrument = SimulatedVna(
            self.sweeper,
            clock,
            InstrumentScene(**description),
            self.faults,
            seconds_per_point,
            lambda kind, reply: self.captured.append((kind, reply)),
        )
        self.sweeper.start()

    def send(self, text):
        return self.instrument.execute(text if isinstance(text, bytes) else text.encode())

    def ask(self, text):
        """Return the answer without its newline, as text."""
        return self.send(text).answer.decode("latin-1").rstrip("\n")

    def stop(self):
        self.sweeper.stop()


def block_content(reply):
    """Return what a block holds after checking its header."""
    assert reply[:1] == b"#"
    digits = int(reply[1:2])
    length = int(reply[2 : 2 + digits])
    content = reply[2 + digits :].rstrip(b"\n") if b"," in reply else reply[2 + digits :]
    assert len(content[:length]) == length
    return content[:length]


def ascii_numbers(reply):
    return np.array([float(one) for one in block_content(reply).decode().split(",") if one])


def real_numbers(reply):
    return np.frombuffer(block_content(reply), "<f4")


def complex_numbers(numbers):
    return numbers[0::2] + 1j * numbers[1::2]


def new_bench(request, **options):
    """Return a bench of other options that ends with the test."""
    one = Bench(**options)
    request.addfinalizer(one.stop)
    return one


def swept(bench, points=11):
    """Hold, set the sweep, run it once and return its data in REAL,32."""
    bench.send(f":INIT:CONT OFF;:SWE:POIN {points};:SENS:TRACE1:SPAR S21;:FORM REAL,32;:INIT:IMM")
    wait_until(lambda: bench.ask(":STAT:OPER?") == "256", "end of the sweep")
    return bench.send(":CALC1:DATA? SDAT").answer
