"""Analyzers of other makers, simulated below PyVISA: SCPI over a TCP socket.

The real part of each point is the number of its sweep; the imaginary part differs at every point.
"""

from __future__ import annotations

import contextlib
import socket
import socketserver
import struct
import threading
from typing import Callable, ClassVar, Dict, List, Optional, Set, Tuple

import numpy as np

from gpr20_common.low.clock import Clock


class Dropped(Exception):
    """The instrument closes the connection."""


class SweepClock(Clock):
    """Time passes only while somebody waits for a sweep, or pauses."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._now_s = 1000.0

    def now_s(self) -> float:
        return self._now_s

    def pass_until(self, time_s: float) -> None:
        with self._lock:
            self._now_s = max(self._now_s, time_s)

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        if not event.is_set():
            self.pass_until(self._now_s + timeout_s)
        return event.is_set()


class ScpiAnalyzer:
    """What the simulated analyzers have in common: settings, and sweeps that take time."""

    maker, model = "", ""
    # Which command makes it sweep by itself, and with which value.
    continuous: Tuple[str, str] = ("", "")
    settings: ClassVar[Dict[str, str]] = {}
    points_header = ""

    def __init__(self) -> None:
        self.sweep_s = 0.02
        self.clock = SweepClock()
        # What it does wrong: queries that it does not answer ("" means all), and one at which it
        # closes the connection, once.
        self.silent: Set[str] = set()
        self.drop_at = ""
        # Commands that it does not carry out, and other answers than the right ones, by query.
        self.ignored: Set[str] = set()
        self.answers: Dict[str, bytes] = {}
        # Whether it answers `*OPC?` before the sweep has ended, and always shows the same sweep.
        self.early_end = self.old_data = False
        self.values = dict(self.settings)
        self.values[self.continuous[0]] = self.continuous[1]
        self.written: List[str] = []
        self.sweeps = 0
        self._begun_s = 0.0
        self._selected = ""

    @property
    def identity(self) -> str:
        return f"{self.maker},{self.model},SIMULATED-1,A.01.00"

    @property
    def points(self) -> int:
        return int(float(self.values[self.points_header]))

    @property
    def is_continuous(self) -> bool:
        return self.values[self.continuous[0]] == self.continuous[1]

    def execute(self, message: bytes) -> Optional[bytes]:
        """Carry out one message; return the answer, if there is one."""
        answer = None
        for part in message.decode("ascii").strip().split(";"):
            answer = self._execute(part.lstrip(":"))
        return answer

    def _execute(self, text: str) -> Optional[bytes]:
        if text == self.drop_at:
            self.drop_at = ""
            raise Dropped
        if "?" not in text:
            self.written.append(text)
            if text.split(" ")[0] not in self.ignored:
                self.command(*text.split(" ", 1))
            return None
        if {"", text} & self.silent:
            return None
        if text in self.answers:
            return self.answers[text]
        return self.query(text)

    def command(self, header: str, value: str = "") -> None:
        if header in self.values:
            self.values[header] = value

    def query(self, text: str) -> bytes:
        if text == "*IDN?":
            return self.identity.encode() + b"\n"
        if text == "*OPC?":
            if not self.early_end:
                self.clock.pass_until(self._begun_s + self.sweep_s)
            return b"+1\n"
        return self.values[text.rstrip("?")].encode() + b"\n"

    def trigger(self) -> None:
        self.sweeps += 1
        self._begun_s = self.clock.now_s()

    def data(self) -> np.ndarray:
        """Return real and imaginary part of each point in turn."""
        points, number = self.points, 1 if self.old_data else self.sweeps
        share = (self.clock.now_s() - self._begun_s) / self.sweep_s
        new = np.arange(points) < share * points
        numbers = np.empty(2 * points)
        numbers[0::2] = np.where(new, number, number - 1)
        numbers[1::2] = np.arange(1, points + 1) * 1e-3 + 1e-6 * numbers[0::2]
        return numbers


class PnaAnalyzer(ScpiAnalyzer):
    """A Keysight PNA."""

    maker, model = "Agilent Technologies", "N5222A"
    continuous = ("SENS1:SWE:MODE", "CONT")
    points_header = "SENS1:SWE:POIN"
    settings: ClassVar[Dict[str, str]] = {
        "SENS1:FREQ:STAR": "+1.000000000000E+007",
        "SENS1:FREQ:STOP": "+2.650000000000E+010",
        "SENS1:SWE:POIN": "201",
        "SENS1:BWID": "+1.000E+005",
        "SENS1:SWE:TYPE": "LIN",
        "SENS1:AVER:STATE": "1",
        "TRIG:SOUR": "IMM",
        "SYST:ACT:CHAN": "1",
        "FORM": "ASC,+0",
        "FORM:BORD": "NORM",
        "DISP:WIND:CAT": '"1"',
    }
    catalog_query, create, select = "CALC1:PAR:CAT:EXT?", "CALC1:PAR:EXT", "CALC1:PAR:SEL"
    quote = '"'

    def __init__(self) -> None:
        super().__init__()
        self.measurements = {"CH1_S11_1": "S11"}

    def command(self, header: str, value: str = "") -> None:
        if header == "SENS1:SWE:MODE" and value == "SING":
            self.trigger()
            value = "HOLD"
        if header == self.create:
            name, what = value.replace("'", "").split(",")
            self.measurements[name] = what
        elif header == self.select:
            self._selected = value.split("'")[1]
        else:
            super().command(header, value)

    def query(self, text: str) -> bytes:
        quoted = f"{self.quote}{{}}{self.quote}\n".format
        if text == self.catalog_query:
            return quoted(",".join(f"{a},{b}" for a, b in self.measurements.items())).encode()
        if text == f"{self.select}?":
            return quoted(self._selected).encode()
        if text == "CALC1:DATA? SDATA":
            return self.block(self.data())
        if text == "SENS1:SWE:TIME?":
            return f"{self.sweep_s:E}\n".encode()
        return super().query(text)

    def block(self, numbers: np.ndarray) -> bytes:
        if self.values["FORM"] != "REAL,64":
            return ",".join(f"{one:.12E}" for one in numbers).encode() + b"\n"
        order = "<" if self.values["FORM:BORD"] == "SWAP" else ">"
        packed = struct.pack(f"{order}{len(numbers)}d", *numbers)
        size = str(len(packed))
        return b"#" + str(len(size)).encode() + size.encode() + packed + b"\n"


class ZvaAnalyzer(PnaAnalyzer):
    """A Rohde & Schwarz ZVA."""

    maker, model = "Rohde-Schwarz", "ZVA24-2Port"
    continuous = ("INIT1:CONT", "1")
    settings: ClassVar[Dict[str, str]] = {
        **{key: text for key, text in PnaAnalyzer.settings.items() if "MODE" not in key},
        "INST:NSEL": "1",
        "FORM": "ASC,0",
    }
    catalog_query, create = "CALC1:PAR:CAT?", "CALC1:PAR:SDEF"
    quote = "'"

    def command(self, header: str, value: str = "") -> None:
        if header == "INIT1:IMM":
            self.trigger()
        else:
            super().command(header, value)


class FieldFoxAnalyzer(ScpiAnalyzer):
    """A Keysight FieldFox."""

    maker, model = "Keysight Technologies", "N9916A"
    continuous = ("INIT:CONT", "1")
    points_header = "SENS:SWE:POIN"
    settings: ClassVar[Dict[str, str]] = {
        "SENS:FREQ:STAR": "30000",
        "SENS:FREQ:STOP": "1.4E+10",
        "SENS:SWE:POIN": "201",
        "SENS:SWE:TIME": "0",
        "SENS:BWID": "3.000E+03",
        "SENS:AVER:COUN": "4",
        "CALC:PAR:COUN": "1",
        "CALC:PAR1:DEF": "S11",
        "CALC:PAR1:SEL": "",
        "FORM": "REAL,32",
    }

    def command(self, header: str, value: str = "") -> None:
        if header == "INIT:IMM":
            self.trigger()
        else:
            super().command(header, value)

    def query(self, text: str) -> bytes:
        if text == "CALC:DATA:SDATA?":
            return ",".join(f"{one:.12E}" for one in self.data()).encode() + b"\n"
        return super().query(text)


class ScpiServer(socketserver.ThreadingTCPServer):
    """Serves an analyzer on a TCP port of loopback, one message per line."""

    daemon_threads = True

    def __init__(self, analyzer: ScpiAnalyzer) -> None:
        super().__init__(("127.0.0.1", 0), _Lines)
        self.analyzer, self.connections = analyzer, []
        self.address = f"TCPIP0::127.0.0.1::{self.server_address[1]}::SOCKET"
        threading.Thread(target=self.serve_forever, args=(0.01,), daemon=True).start()

    def drop_all(self) -> None:
        """Close every connection."""
        for connection in self.connections:
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)

    def stop(self) -> None:
        self.shutdown()
        self.server_close()
        self.drop_all()


class _Lines(socketserver.StreamRequestHandler):
    disable_nagle_algorithm = True

    def handle(self) -> None:
        self.server.connections.append(self.connection)
        with contextlib.suppress(OSError, ValueError, Dropped):
            for line in self.rfile:
                # Else a client that sends two small messages waits 40 ms in between.
                self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
                answer = self.server.analyzer.execute(line)
                if answer is not None:
                    self.wfile.write(answer)


ANALYZERS: Dict[str, Callable[[], ScpiAnalyzer]] = {
    "keysight.PNA": PnaAnalyzer,
    "keysight.FieldFox": FieldFoxAnalyzer,
    "rohde_schwarz.ZVA": ZvaAnalyzer,
    "rohde_schwarz.ZNA": ZvaAnalyzer,
}
