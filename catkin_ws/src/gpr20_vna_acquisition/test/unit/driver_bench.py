"""A driver at an instrument without a network, and a clock without waiting."""

from __future__ import annotations

import struct
import threading
from dataclasses import replace
from typing import Callable, Dict, List, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaNoAnswerError
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

IDENTITY = "Anritsu,MS2026C/2,1234567,1.23"
OTHER_IDENTITY = '"Anritsu,MS2026C/2,7654321,1.23"'
EXCHANGE_S = 0.001
ADDRESS = "192.168.1.10"
SWEEP = SweepSettings(600e6, 6e9, 11)
# As the instrument confirms it: with its own values of what was left to it.
ACCEPTED = replace(SWEEP, analyzer=AnalyzerSettings(10_000.0, 1, "HIGH"))
STARTED_US = 1_800_000_000_123_456
# What a preamble calls the settings.
PREAMBLE_SETTINGS = {
    "SWEEP_TYPE": ":INIT:CONT",
    "TRACE_1_START_FREQ": ":SENS:FREQ:STAR",
    "TRACE_1_STOP_FREQ": ":SENS:FREQ:STOP",
    "TRACE_1_DSP_DATA_POINTS": ":SENS:SWE:POIN",
    "TOTAL_TRACE": ":SENS:TRAC:TOT",
    "S_TYPE": ":SENS:TRACE1:SPAR",
    "DOMAIN": ":SENS:TRACE1:DOM",
    "IFBW": ":SENS:SWE:IFBW",
    "AVERAGING_FACTOR": ":SENS:AVER:COUN",
    "RF_SOURCE_POWER": ":SOUR:POW",
}


class FakeClock(Clock):
    """Time passes only when someone waits or `pass_s` is called."""

    def __init__(self) -> None:
        self.time_s = 100.0

    def pass_s(self, duration_s: float) -> None:
        self.time_s += duration_s

    def now_s(self) -> float:
        return self.time_s

    def sleep_until_s(self, deadline_s: float) -> None:
        self.time_s = max(self.time_s, deadline_s)

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        if not event.is_set():
            self.time_s += timeout_s
        return event.is_set()


class FakeVna:
    """The instrument: stores settings, sweeps in fake time, and can be made to misbehave.

    The real part of every point is the number of the sweep, the imaginary part that of the point.
    Points that a sweep has not come to yet are those of the sweeps before.
    """

    def __init__(self, clock: FakeClock) -> None:
        self.clock = clock
        # Time that each message takes.
        self.exchange_s = EXCHANGE_S
        self.identity = f'"{IDENTITY}"'
        self.settings: Dict[str, str] = {
            ":INIT:CONT": "1",
            ":SENS:FREQ:STAR": "5000",
            ":SENS:FREQ:STOP": "6000000000",
            ":SENS:SWE:POIN": "201",
            ":SENS:TRAC:TOT": "4",
            ":SENS:TRACE1:SPAR": "S11",
            ":SENS:TRACE1:DOM": "TIME",
            ":SENS:AVER:COUN": "1",
            ":SENS:SWE:IFBW": "10000",
            ":SOUR:POW": "HIGH",
            ":FORM": "ASC",
        }
        self.refused: List[str] = []
        self.sweep_s = 0.05
        self.stale_bit_s = 0.0
        # Whether one trigger makes all sweeps of an average.
        self.averages_at_once = False
        self.averaged = 0
        # Queries that get no answer.
        self.unanswered: List[str] = []
        self.local = False
        self.sweep_number = 0
        # Duration of the last sweep, which began before `sweep_s` was changed.
        self._running_s = 0.0
        self._shown: List[float] = []
        self.sweep_begun_s = -1.0
        # How long after the end of a sweep its data replace those that are shown, and what will be
        # shown from when on.
        self.late_memory_s = 0.0
        self._coming: List[Tuple[float, List[float]]] = []
        self._late_shown: List[float] = []
        self.calibration = "1"
        self.calibrated = "15"
        # What the preamble says besides the settings; None: it says nothing of those either.
        self.preamble: Optional[Dict[str, str]] = {
            "SN": IDENTITY.split(",")[2],
            "CAL_CORRECTION": "0",
            "CURRENT_TEMPERATURE": "163",
            "SMOOTHING_PERCENT": "0",
            "TRACE_MATH_TYPES": "0",
        }
        self.locked = False
        # A name that the preamble does not have.
        self.left_out = ""
        # Called with each query or command; may change the fake or raise.
        self.before: Callable[[str], None] = lambda message: None
        # Called with each data answer; returns what is sent instead.
        self.spoil: Callable[[bytes], bytes] = lambda answer: answer
        self.sent: List[str] = []
        self.links = 0
        self.open_links = 0

    @property
    def points(self) -> int:
        return int(self.settings[":SENS:SWE:POIN"])

    def connect(self, address: str) -> FakeLink:
        self.local = False
        self.links += 1
        self.open_links += 1
        return FakeLink(self)

    def take(self, command: str) -> None:
        if ";" in command:
            for one in command.split(";"):
                self.take(one)
            return
        header, _, value = command.partition(" ")
        if header == ":SENS:AVER:CLE":
            self.averaged = 0
        elif header == ":INIT:IMM":
            averages = int(self.settings[":SENS:AVER:COUN"])
            self.averaged = averages if self.averages_at_once else min(self.averaged + 1, averages)
            self._shown = self._measured()[0::2]
            self._late_shown = self.points_data()
            self.sweep_number += 1
            self.sweep_begun_s = self.clock.time_s
            self._running_s = self.sweep_s
            if self.late_memory_s:
                self.show_later(self.sweep_number, self.sweep_s + self.late_memory_s)
        elif header in self.settings and header not in self.refused:
            self.settings[header] = {"OFF": "0", "ON": "1"}.get(value, value)

    def answer(self, query: str) -> bytes:
        header, _, _ = query.partition("?")
        if header in self.settings:
            return self.settings[header].encode()
        return self._answers()[header]()

    def _answers(self) -> Dict[str, Callable[[], bytes]]:
        return {
            "*IDN": lambda: self.identity.encode(),
            ":STAT:OPER": lambda: b"256" if self._bit() else b"0",
            ":SENS:CORR:COLL:STAT:ACC": self.calibration.encode,
            ":TRAC:PRE": self._preamble,
            ":SENS:CAL:STAT": self.calibrated.encode,
            ":SENS:CORR:COLL:TYPE": lambda: b"2PFP",
            ":SENS:CORR:COLL:INT": lambda: b"0",
            ":SENSE1:FREQ:DATA": lambda: self.block(self._frequencies()),
            ":CALC1:DATA": lambda: self.spoil(self.block(self.points_data())),
        }

    def _bit(self) -> bool:
        elapsed_s = self.clock.time_s - self.sweep_begun_s
        return elapsed_s < self.stale_bit_s or elapsed_s >= self._running_s

    def _frequencies(self) -> List[float]:
        start = float(self.settings[":SENS:FREQ:STAR"])
        stop = float(self.settings[":SENS:FREQ:STOP"])
        return [start + i * (stop - start) / (self.points - 1) for i in range(self.points)]

    def show_later(self, real: float, late_s: float) -> None:
        """Let a sweep with this real part be shown after some time, as if it had just ended."""
        self._coming.append((self.clock.time_s + late_s, _interleaved([real] * self.points)))

    def set_late(self, late_s: float) -> None:
        """Show what is shown now until the next sweep has ended, and for some time after."""
        self._late_shown, self.late_memory_s = self.points_data(), late_s

    def _preamble(self) -> bytes:
        values = {"AVERAGING_COUNT": str(self.averaged)}
        if self.preamble is not None:
            for name, header in PREAMBLE_SETTINGS.items():
                values[name] = self.settings.get(header, "")
            values.update(self.preamble)
        values.pop(self.left_out, None)
        text = ",".join(f"{name}={value}" for name, value in values.items()).encode()
        return b"#9%09d%s\n" % (len(text), text)

    def points_data(self) -> List[float]:
        while self._coming and self._coming[0][0] <= self.clock.time_s:
            _due_s, self._late_shown = self._coming.pop(0)
        return self._late_shown if self.late_memory_s else self._measured()

    def _measured(self) -> List[float]:
        if len(self._shown) != self.points:
            self._shown = [0.0] * self.points
        elapsed_s, done = self.clock.time_s - self.sweep_begun_s, self.points
        if elapsed_s < self._running_s:
            done = int(self.points * elapsed_s / self._running_s)
        return _interleaved([float(self.sweep_number)] * done + self._shown[done:])

    def block(self, numbers: List[float]) -> bytes:
        if self.settings[":FORM"] == "REAL,32":
            payload = struct.pack(f"<{len(numbers)}f", *numbers)
        else:
            payload = "".join(f"{number:.9E}," for number in numbers).encode()
        return f"#{len(str(len(payload)))}{len(payload)}".encode() + payload + b"\n"


def _interleaved(real: List[float]) -> List[float]:
    return [value for point, one in enumerate(real) for value in (one, float(point))]


class FakeLink:
    """One link to a FakeVna; dead after the first failure, like the real one."""

    def __init__(self, vna: FakeVna) -> None:
        self._vna = vna
        self._open = True

    def write(self, command: str) -> None:
        self._exchange(command)
        self._vna.take(command)

    def ask_raw(self, query: str, limit_s: Optional[float] = None) -> bytes:
        self._exchange(query)
        if query in self._vna.unanswered:
            self._vna.clock.pass_s(5.0 if limit_s is None else limit_s)
            self.close()
            raise VnaNoAnswerError(Message("no answer in time"))
        return self._vna.answer(query)

    def lock(self) -> None:
        self._exchange("<lock>")
        self._vna.locked = True

    def local(self) -> None:
        self._exchange("<local>")
        self._vna.local = True

    def clear(self) -> None:
        self._exchange("<clear>")

    def close(self) -> None:
        if self._open:
            self._open = self._vna.locked = False
            self._vna.open_links -= 1

    def _exchange(self, message: str) -> None:
        if not self._open:
            raise VnaConnectionError(Message("the link is dead"))
        self._vna.sent.append(message)
        self._vna.clock.pass_s(self._vna.exchange_s)
        try:
            self._vna.before(message)
        except VnaConnectionError:
            self.close()
            raise


class Bench:
    """A driver at a fake instrument."""

    def __init__(self, **parameters) -> None:
        self.clock = FakeClock()
        self.vna = FakeVna(self.clock)
        self.warnings: List[str] = []
        values = VnaParameters(**parameters)
        self.deadline = RequestDeadline(self.clock)
        self.analyzer = Ms2026c(self.vna.connect, values, self.deadline, lambda: STARTED_US)
        self.driver = VNADriver(self.analyzer, values, self.deadline, self.warnings.append)

    def configured(self) -> Bench:
        self.driver.connect_to_vna(ADDRESS)
        self.driver.set_frequency_sweep(SWEEP)
        return self

    @property
    def taken(self) -> int:
        """The number of a sweep that is taken now, to be confirmed."""
        return self.driver.take_sweep()[0]

    def lose_link_once(self, when: str = "") -> None:
        """Break the link at the next message that begins with `when`."""

        def before(message: str) -> None:
            if message.startswith(when):
                self.vna.before = lambda _message: None
                raise VnaConnectionError(Message("broken on purpose"))

        self.vna.before = before

    def lose_calibration_at(self, command: str) -> None:
        """Let a command that begins so end the calibration."""

        def before(message: str) -> None:
            if message.startswith(command):
                self.vna.calibration = "0"

        self.vna.before = before
