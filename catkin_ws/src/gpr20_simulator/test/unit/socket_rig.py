"""The whole simulated analyzer behind a real VXI-11 socket, with a client."""

from __future__ import annotations

import vxi11
from rpc_wire import wait_until
from vna_bench import Carriage, block_content, complex_numbers, real_numbers

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, SimulatedAnalyzer
from gpr20_simulator.mid.world.medium import PositionProbe

POINT_S = 350e-6
POINTS = 401
SWEEP_S = POINTS * POINT_S
SETUP = (
    ":SENS:FREQ:STAR 600000000",
    ":SENS:FREQ:STOP 6000000000",
    f":SENS:SWE:POIN {POINTS}",
    ":SENS:TRACE1:SPAR S21",
    ":FORM REAL,32",
)


class Rig:
    def __init__(self, clock=None, description=None, **options):
        self.carriage = Carriage()
        self.captured = []
        self.vna = SimulatedAnalyzer(
            PositionProbe(),
            self.carriage.position,
            clock or Clock(),
            description or InstrumentScene(),
            AnalyzerOptions(POINT_S, **options),
            lambda kind, reply: self.captured.append((kind, reply)),
        )
        self.vna.start()
        self.client = self.connected()
        for command in SETUP:
            self.client.write(command)

    def connected(self):
        client = vxi11.Instrument("127.0.0.1")
        client.client = vxi11.vxi11.CoreClient("127.0.0.1", self.vna.server.port)
        client.timeout = 5.0
        client.open()
        return client

    def data(self):
        return complex_numbers(real_numbers(self.client.ask_raw(b":CALC1:DATA? SDAT")))

    def preamble(self):
        content = block_content(self.client.ask_raw(b":TRAC:PRE? 1")).decode()
        return dict(pair.split("=") for pair in content.split(","))

    def wait_for_sweep(self):
        wait_until(lambda: self.client.ask(":STAT:OPER?") == "256", "end of the sweep")

    def stop(self):
        self.client.client.sock.close()
        self.client.link = None
        self.vna.stop()
