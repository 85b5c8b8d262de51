"""A simulated analyzer in this process, with movable antennas."""

from __future__ import annotations

import numpy as np

from gpr20_simulator.mid.analyzer.simulated_analyzer import InProcessAnalyzer
from gpr20_simulator.mid.analyzer.sweeper import SweepPace
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe, probed_sweep
from gpr20_simulator.mid.world.scene import InstrumentScene

# Of a sweep that takes time: its points, and the time of each [s].
POINTS, POINT_S = 101, 350e-6
SWEEP_S = POINTS * POINT_S


class Bench(InProcessAnalyzer):
    """An instrument in hold that has swept once, and its antennas."""

    def __init__(self, points=POINTS, pace=None, **description):
        self.here = AntennaPosition(0.0, 0.0, 0.0)
        scene = InstrumentScene(**description)
        super().__init__(PositionProbe(), lambda: self.here, scene, pace or SweepPace())
        self.send(f":INIT:CONT OFF;:SWE:POIN {points};:SENS:TRACE1:SPAR S21;:FORM REAL,32")
        self.pass_s(3.0)
        self.sweep()

    def move(self, x_mm):
        self.here = AntennaPosition(x_mm, 0.0, 0.0)

    def pass_s(self, seconds):
        self.time.sleep_until_s(self.time.now_s() + seconds)

    def send(self, text):
        return self.instrument.execute(text if isinstance(text, bytes) else text.encode())

    def ask(self, text):
        """Return the answer without its newline, as text."""
        return self.send(text).answer.decode("latin-1").rstrip("\n")

    def data(self):
        return self.send(":CALC1:DATA? SDAT").answer

    def sweep(self, after_s=2.0 * SWEEP_S):
        """Trigger a sweep, let time pass, and return its data."""
        self.send(":INIT:IMM")
        self.pass_s(after_s)
        assert self.ask(":STAT:OPER?") == "256"
        return self.data()

    def values(self):
        numbers = real_numbers(self.data())
        return numbers[0::2] + 1j * numbers[1::2]

    def sweeps(self):
        """Return the number of the sweep that each point is from."""
        return [probed_sweep(value) for value in self.values()]

    def preamble(self):
        content = block_content(self.send(":TRAC:PRE? 1").answer).decode()
        return dict(pair.split("=") for pair in content.split(","))


def block_content(reply):
    """Return what a block holds after checking its header and its newline."""
    digits = int(reply[1:2])
    length = int(reply[2 : 2 + digits])
    assert reply[:1] == b"#" and reply[-1:] == b"\n" and len(reply) == 3 + digits + length
    return reply[2 + digits : -1]


def ascii_numbers(reply):
    return np.array([float(one) for one in block_content(reply).decode().split(",") if one])


def real_numbers(reply):
    return np.frombuffer(block_content(reply), "<f4")
