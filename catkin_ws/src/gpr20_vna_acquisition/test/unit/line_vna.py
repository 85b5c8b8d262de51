"""A simulated analyzer that speaks SCPI in lines of text over a socket."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from typing import List

import numpy as np

# A cable of 0.6 m.
DELAY_S = 3e-9


class LineVna:
    """Answers one client at a time.

    Attributes:
        port: Its TCP port.
        values: Its settings, by command.
        written: The commands that changed something.
        identity: Its answer to `*IDN?`.
        drop_at: A query at which it closes the connection, once.
        level: Magnitude of what it sees.
        sweeps: How many it has made.
    """

    def __init__(self) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(0.05)
        self.port = self._listener.getsockname()[1]
        self.identity = "CMT,S5085,SIMULATED-1,22.1"
        self.values = {
            "SENS1:FREQ:STAR": "300000",
            "SENS1:FREQ:STOP": "8.5e9",
            "SENS1:SWE:POIN": "201",
            "SENS1:BWID": "10000",
            "SENS1:AVER:COUN": "1",
            "SENS1:CORR:STAT": "1",
            "TRIG:SOUR": "INT",
            "INIT1:CONT": "1",
            "CALC1:PAR1:DEF": "S11",
        }
        self.written: List[str] = []
        self.drop_at = ""
        self.level = 0.1
        self.sweeps = 0
        self._ended_s = 0.0

    def __enter__(self) -> LineVna:
        threading.Thread(target=self._serve, daemon=True).start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._listener.close()

    def _serve(self) -> None:
        while True:
            try:
                client, _address = self._listener.accept()
            except socket.timeout:
                continue
            except OSError:
                return  # it is closed
            # A client may end its link at any time.
            with contextlib.suppress(OSError), client, client.makefile("r") as lines:
                for line in lines:
                    # Else a client that sends two small messages waits 40 ms in between.
                    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
                    answer = self._answer(line.strip())
                    if answer is None:
                        break
                    client.sendall(answer.encode("ascii"))

    def _answer(self, line: str):
        if line == self.drop_at:
            self.drop_at = ""
            return None
        if line.endswith("?"):
            return f"{self._asked(line[:-1])}\n"
        self.written.append(line)
        if line == "TRIG:SING":
            self.sweeps += 1
            self._ended_s = time.monotonic() + self._sweep_s()
        elif line != "SENS1:AVER:CLE":
            command, value = line.split(" ")
            self.values[command] = value
        return ""

    def _asked(self, query: str) -> str:
        if query == "*IDN":
            return self.identity
        if query == "*OPC":
            time.sleep(max(0.0, self._ended_s - time.monotonic()))
            return "1"
        if query == "SENS1:SWE:TIME":
            return str(self._sweep_s())
        if query == "CALC1:DATA:SDAT":
            return ",".join(map(str, self._seen().view(np.float64)))
        return self.values[query]

    def _sweep_s(self) -> float:
        return 2.0 * int(self.values["SENS1:SWE:POIN"]) / float(self.values["SENS1:BWID"])

    def _seen(self) -> np.ndarray:
        start_hz, stop_hz, points = (
            float(self.values[f"SENS1:{one}"]) for one in ("FREQ:STAR", "FREQ:STOP", "SWE:POIN")
        )
        frequencies_hz = np.linspace(start_hz, stop_hz, int(points))
        noise = np.random.default_rng(self.sweeps).normal(size=(2, int(points)))
        seen = self.level * np.exp(-2j * np.pi * frequencies_hz * DELAY_S)
        return seen + 1e-5 * (noise[0] + 1j * noise[1])
