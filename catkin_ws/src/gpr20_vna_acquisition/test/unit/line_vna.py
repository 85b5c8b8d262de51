"""A simulated analyzer that speaks SCPI in lines of text over a socket.

The real part of the first point is the number of its sweep.
"""

from __future__ import annotations

import socket
import threading
import time
from typing import List

SWEEP_S = 0.005


class LineVna:
    """Answers one client at a time.

    Attributes:
        port: Its TCP port.
        values: Its settings, by command.
        written: The commands that changed something.
        identity: Its answer to `*IDN?`.
        drop_at: A query at which it closes the connection, once.
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
            "SENS1:SWE:TIME": str(SWEEP_S),
            "TRIG:SOUR": "INT",
            "INIT1:CONT": "1",
            "CALC1:PAR1:DEF": "S11",
        }
        self.written: List[str] = []
        self.drop_at = ""
        self._sweeps = 0
        self._ended_s = 0.0
        self._open = True
        self._thread = threading.Thread(target=self._serve)

    def __enter__(self) -> LineVna:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._open = False
        self._thread.join()
        self._listener.close()

    def _serve(self) -> None:
        while self._open:
            try:
                client, _address = self._listener.accept()
            except socket.timeout:
                continue
            with client, client.makefile("r", encoding="ascii") as lines:
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
            self._sweeps += 1
            self._ended_s = time.monotonic() + SWEEP_S
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
        if query == "CALC1:DATA:SDAT":
            points = int(self.values["SENS1:SWE:POIN"])
            return ",".join(f"{self._sweeps + i / 1e6},{-0.5 - i / 1e3}" for i in range(points))
        return self.values[query]
