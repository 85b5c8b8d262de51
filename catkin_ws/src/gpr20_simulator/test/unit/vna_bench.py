"""A simulated analyzer on the bench: probe medium, movable antennas, real or hand-driven clock."""

from __future__ import annotations

import time

import numpy as np

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.instrument import SimulatedVna
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.sweeper import Sweeper, SweepPace
from gpr20_simulator.mid.analyzer.vna_settings import VnaSettings
from gpr20_simulator.mid.faults import FaultBoard
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe, probed_sweep

LIMIT_S = 30.0


def wait_until(condition, what):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, f"{what} did not happen within {LIMIT_S} s"
        time.sleep(0.002)


class HandClock(Clock):
    """Time passes only when the test says so."""

    def __init__(self):
        self._now_s = 1000.0

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
        self.calls, self.gains = 0, set()

    def s21(self, frequency_hz, position, sweep_number, noise_gain=1.0):
        self.calls += 1
        self.gains.add(noise_gain)
        return super().s21(frequency_hz, position, sweep_number, noise_gain)


class Carriage:
    """Antennas that are where the test put them."""

    def __init__(self):
        self.here = AntennaPosition(0.0, 0.0, 0.0)

    def move(self, x_mm, y_mm=0.0, rotation_deg=0.0):
        self.here = AntennaPosition(x_mm, y_mm, rotation_deg)

    def position(self):
        return self.here


# Of a sweep that takes time: its points, and the time of each [s].
POINTS, POINT_S = 101, 0.001
SWEEP_S = POINTS * POINT_S


class Bench:
    """An instrument without network; its sweeps take no time unless said."""

    def __init__(self, clock=None, seconds_per_point=0.0, medium=None, **description):
        self.clock = clock or Clock()
        self.carriage = Carriage()
        self.faults = FaultBoard()
        self.captured = []
        scene = InstrumentScene(**description)
        plan = VnaSettings().plan(seconds_per_point, scene.averaging)
        self.sweeper = Sweeper(
            medium or PositionProbe(), self.carriage.position, self.clock, plan, SweepPace()
        )
        self.instrument = SimulatedVna(
            self.sweeper,
            self.clock,
            scene,
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

    def data(self):
        return self.send(":CALC1:DATA? SDAT").answer

    def sweep_numbers(self):
        """Return the numbers of the sweeps that the points are from."""
        numbers = real_numbers(self.data())
        return {probed_sweep(value) for value in numbers[0::2] + 1j * numbers[1::2]}

    def preamble(self):
        content = block_content(self.send(":TRAC:PRE? 1").answer).decode()
        return dict(pair.split("=") for pair in content.split(","))

    def wait_for_bit(self):
        wait_until(lambda: self.ask(":STAT:OPER?") == "256", "end of the sweep")

    def sweep(self, after_s=2.0 * SWEEP_S):
        """Trigger a sweep, let time pass, and wait for its end."""
        self.send(":INIT:IMM")
        self.clock.advance(after_s)
        self.wait_for_bit()

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


def new_bench(request, **options):
    """Return a bench of other options that ends with the test."""
    one = Bench(**options)
    request.addfinalizer(one.stop)
    return one


def timed_bench(request, **description):
    """Return a bench whose sweeps take the time of a hand clock, after one of them."""
    one = new_bench(request, clock=HandClock(), seconds_per_point=POINT_S, **description)
    one.send(f":INIT:CONT OFF;:SWE:POIN {POINTS};:SENS:TRACE1:SPAR S21;:FORM REAL,32")
    one.sweep()
    return one


def swept(bench, points=11):
    """Hold, set the sweep, run it once and return its data in REAL,32."""
    bench.send(f":INIT:CONT OFF;:SWE:POIN {points};:SENS:TRACE1:SPAR S21;:FORM REAL,32;:INIT:IMM")
    bench.wait_for_bit()
    return bench.data()
