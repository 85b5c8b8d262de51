#!/usr/bin/env python3
"""Bytes and time of a trace on loopback: 501 and 4001 points, ASCII and REAL,32.

The simulated instrument runs in a process of its own and sweeps in no time, so that what is left
is the way of the data: the instrument writes its numbers, VXI-11 carries them, the driver reads
them. All formats take turns in one run.
"""

from __future__ import annotations

import argparse
import multiprocessing
import statistics
import time
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from typing import List

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.medium import AntennaPosition
from gpr20_simulator.mid.scene import Scene
from gpr20_simulator.mid.simulated_analyzer import (
    AnalyzerOptions,
    SimulatedAnalyzer,
    medium_by_name,
)
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, Vxi11Transport, connect
from gpr20_vna_acquisition.mid.block_parser import TransferFormat, parse_numbers
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

HOST = "127.0.0.1"
POINTS = (501, 4001)
QUERY = ":CALC1:DATA? SDAT"
LONGEST_RUN_S = 600.0
START_LIMIT_S = 30.0


@dataclass
class Case:
    """One size and format, and what was measured of it [s]."""

    points: int
    transfer: TransferFormat
    size_bytes: int = 0
    transfers_s: List[float] = field(default_factory=list)
    parsings_s: List[float] = field(default_factory=list)
    requests_s: List[float] = field(default_factory=list)

    def measure(self, link: Vxi11Transport, rounds: int) -> None:
        """Take so many traces and note how long each step takes."""
        parameters = VnaParameters(transfer_format=self.transfer, seconds_per_point=0.0)
        deadline = RequestDeadline(Clock())
        deadline.begin(LONGEST_RUN_S)
        instrument = Ms2026c(lambda _address: link, parameters, deadline)
        instrument.connect(HOST)
        instrument.identify()
        instrument.configure(SweepSettings(600e6, 6e9, self.points))
        for _ in range(rounds):
            begun_s = time.perf_counter()
            instrument.sweep()
            instrument.confirm()
            asked_s = time.perf_counter()
            answer = link.ask_raw(QUERY)
            answered_s = time.perf_counter()
            parse_numbers(answer, self.transfer, 2 * self.points)
            parsed_s = time.perf_counter()
            self.size_bytes = len(answer)
            self.requests_s.append(asked_s - begun_s)
            self.transfers_s.append(answered_s - asked_s)
            self.parsings_s.append(parsed_s - answered_s)

    def row(self) -> str:
        """Return a row of the table."""
        medians = (
            1e3 * statistics.median(times)
            for times in (self.transfers_s, self.parsings_s, self.requests_s)
        )
        cells = (str(self.points), self.transfer.value, str(self.size_bytes))
        return "| " + " | ".join((*cells, *(f"{median:.2f}" for median in medians))) + " |"


def serve(pipe: Connection) -> None:
    """Run the simulated instrument, print its port, and end on request."""
    scene = Scene()
    vna = SimulatedAnalyzer(
        medium_by_name("scene", scene),
        lambda: AntennaPosition(100.0, 100.0, 0.0),
        Clock(),
        scene.instrument,
        AnalyzerOptions(seconds_per_point=0.0),
    )
    vna.start()
    pipe.send(vna.server.port)
    pipe.recv()
    vna.stop()


def run(rounds: int, turns: int) -> List[Case]:
    here, there = multiprocessing.Pipe()
    server = multiprocessing.Process(target=serve, args=(there,), daemon=True)
    server.start()
    if not here.poll(START_LIMIT_S):
        raise SystemExit(f"the simulated instrument does not answer within {START_LIMIT_S:g} s")
    link = connect(HOST, LinkLimits(), here.recv())
    cases = [Case(points, transfer) for points in POINTS for transfer in TransferFormat]
    for _ in range(turns):
        for case in cases:
            case.measure(link, rounds // turns)
    link.close()
    here.send("end")
    server.join()
    return cases


def ratios(cases: List[Case]) -> str:
    lines = []
    for points in POINTS:
        of = {case.transfer: case for case in cases if case.points == points}
        real, text = of[TransferFormat.REAL32], of[TransferFormat.ASCII]
        size = text.size_bytes / real.size_bytes
        duration = statistics.median(
            sent + parsed for sent, parsed in zip(text.transfers_s, text.parsings_s)
        ) / statistics.median(
            sent + parsed for sent, parsed in zip(real.transfers_s, real.parsings_s)
        )
        lines.append(
            f"{points} points: ASCII has {size:.1f} times the bytes of REAL,32 and takes "
            f"{duration:.1f} times as long to be transferred and parsed"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=400, help="traces of each kind (400)")
    parser.add_argument("--turns", type=int, default=4, help="turns in which they are taken (4)")
    arguments = parser.parse_args()
    cases = run(arguments.rounds, arguments.turns)
    print(f"medians of {len(cases[0].requests_s)} traces of each kind")
    print("| points | format | bytes | transfer [ms] | parsing [ms] | whole request [ms] |")
    print("|---|---|---|---|---|---|")
    for case in cases:
        print(case.row())
    print(ratios(cases))


if __name__ == "__main__":
    main()
