"""A driver at the simulated instrument, in this process and without waiting."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, List, Set

import numpy as np

from gpr20_common.message import Message
from gpr20_simulator.mid.analyzer.simulated_analyzer import CLOSE, CONNECT, InProcessAnalyzer
from gpr20_simulator.mid.analyzer.sweeper import SweepPace
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe
from gpr20_simulator.mid.world.scene import InstrumentScene
from gpr20_survey.trace.sweep import AnalyzerSettings, Sweep, SweepSettings
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

ADDRESS = "192.168.1.10"
POINTS = 11
SWEEP = SweepSettings(600e6, 6e9, POINTS)
# As the instrument confirms it: with its own values of what was left to it.
ACCEPTED = replace(SWEEP, analyzer=AnalyzerSettings(10_000.0, 1, "HIGH"))
STARTED_US = 1_800_000_000_123_456
DATA, TRIGGER, STATUS, PREAMBLE = ":CALC1:DATA? SDAT", ":INIT:IMM", ":STAT:OPER?", ":TRAC:PRE? 1"


class Numbered(PositionProbe):
    """Real part: the number of the sweep; imaginary part: the frequency in GHz."""

    def s21(self, frequency_hz, position, sweep_number, noise_gain=1.0):
        return sweep_number + 1j * frequency_hz / 1e9


def nothing(_message: str) -> None:
    """Let the instrument answer."""


def as_sent(_query: str, answer: bytes) -> bytes:
    """Let the driver read the answer."""
    return answer


class Bench:
    """A driver and its instrument; it is described as a scene does it."""

    def __init__(self, scene: InstrumentScene = InstrumentScene(), **parameters) -> None:  # noqa: B008
        here = AntennaPosition(0.0, 0.0, 0.0)
        self.vna = InProcessAnalyzer(Numbered(), lambda: here, scene, SweepPace())
        self.clock, self.faults = self.vna.time, self.vna.faults
        # What was sent, and how many links were made and are open.
        self.sent: List[str] = []
        self.links = self.open_links = 0
        # Called with each message; may change something, or raise.
        self.before: Callable[[str], None] = nothing
        self.vna.on_message = self._note
        self.values = VnaParameters(**{"max_level_db": 100.0, **parameters})
        self.deadline = RequestDeadline(self.clock)
        limits = LinkLimits(self.values.connect_timeout_s, self.values.answer_timeout_s)
        self.analyzer = Ms2026c(
            lambda address: self.vna.connect(address, limits),
            self.values,
            self.deadline,
            lambda: STARTED_US,
        )
        self.driver = VNADriver(self.analyzer, self.values, self.deadline, print)

    def _note(self, message: str) -> None:
        if message == CLOSE:
            self.open_links -= 1
            return
        self.sent.append(message)
        self.before(message)
        if message == CONNECT:
            self.links += 1
            self.open_links += 1

    def configured(self) -> Bench:
        self.driver.connect_to_vna(ADDRESS)
        self.driver.set_frequency_sweep(SWEEP)
        del self.sent[:]
        return self

    def ask(self, query: str) -> str:
        """Return what the instrument answers to somebody else."""
        return self.vna.instrument.execute(query.encode()).answer.decode().strip()

    def by_hand(self, *commands: str) -> None:
        """Change settings as somebody else does."""
        for one in commands:
            self.vna.instrument.execute(one.encode())

    def is_like(self, **changes) -> None:
        """Let the instrument be another one in some way: fields of its scene."""
        self.vna.instrument.description = replace(self.vna.instrument.description, **changes)

    def takes(self, sweep_s: float, stale_bit_s: float = 0.0, lag_s: float = 0.0) -> None:
        """Let a sweep take so long, its bit clear and its data be shown so late [s]."""
        self.faults.clear()
        self.is_like(slow_point_s=sweep_s / POINTS, late_bit_s=stale_bit_s, late_memory_s=lag_s)
        for fault, on in (("SLOW_POINTS", sweep_s), ("LATE_BIT", stale_bit_s)):
            if on:
                self.faults.set(fault)
        if lag_s:
            self.faults.set("LATE_MEMORY")

    def answers(self, query: str, answer) -> None:
        """Let the driver read another answer to a query: bytes, or what makes them of the right."""
        change = answer if callable(answer) else lambda _right: answer
        self.vna.on_answer = lambda asked, right: change(right) if asked == query else right

    def commands(self) -> Set[str]:
        """Return what was sent without asking."""
        return {one for one in self.sent if "?" not in one and not one.startswith("<")}

    @property
    def number(self) -> int:
        """The number of the sweep that was triggered last."""
        return self.vna.sweeper.sweep_number

    @property
    def taken(self) -> int:
        """The number of a sweep that is taken now, to be confirmed."""
        return self.driver.take_sweep()[0]

    def is_new(self) -> bool:
        """Take a trace; return whether it is all of one sweep, triggered by it."""
        before = self.number
        return is_of_one_after(self.driver.get_trace(), before)

    def lose_link_once(self, when: str = "") -> None:
        """Break the link at the next message that begins with `when`."""

        def before(message: str) -> None:
            if message.startswith(when):
                self.before = nothing
                raise VnaConnectionError(Message("broken on purpose"))

        self.before = before

    def lose_links(self) -> None:
        """Let every message and every new link fail."""

        def gone(_message: str) -> None:
            raise VnaConnectionError(Message("gone"))

        self.before = gone


def is_of_one_after(sweep: Sweep, number: int) -> bool:
    """Return whether every point is of one sweep with a higher number."""
    numbers = set(sweep.s21_real.tolist())
    points = np.allclose(sweep.s21_imag, sweep.frequency_hz / 1e9)
    return points and len(numbers) == 1 and numbers.pop() > number
