"""Draws of sweeps with late bits and late displays, each compared with where it was measured."""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Iterable, Iterator, List, Sequence

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, SimulatedAnalyzer
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import VnaNotReadyError, VnaOldDataError, VnaSettingError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, connect
from gpr20_vna_acquisition.mid.block_parser import TransferFormat
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

HOST = "127.0.0.1"
FAULTS = ("LATE_BIT", "LATE_MEMORY")
DELAYS_S = (0.0, 0.001, 0.003, 0.01, 0.05, 0.2, 1.0)
POINTS = (51, 501, 4000)
SECONDS_PER_POINT = 20e-6
# What the survey measures again.
UNCONFIRMED = (VnaSettingError, VnaOldDataError, VnaNotReadyError)
MOST_REPEATS = 5


@dataclass(frozen=True)
class Cell:
    """One kind of draw."""

    fault: str
    delay_s: float
    transfer: TransferFormat
    points: int


@dataclass
class Count:
    """What came of the draws of a cell.

    Attributes:
        traces: Confirmed traces.
        stale: Those of which a point was measured before the request.
        mixed: Those of which the points are of several sweeps.
        doubled: Those with the data of the trace before.
        repeated: Sweeps that were not confirmed, and measured again.
    """

    traces: int = 0
    stale: int = 0
    mixed: int = 0
    doubled: int = 0
    repeated: int = 0
    last: List[float] = field(default_factory=list)

    def note(self, sweep: Sweep, place_mm: float) -> None:
        """Judge a confirmed trace by where the antennas stood when it was requested."""
        numbers, places = sweep.s21_real.tolist(), set(sweep.s21_imag.tolist())
        self.traces += 1
        self.stale += places != {place_mm}
        self.mixed += len(set(numbers)) > 1 or len(places) > 1
        self.doubled += numbers == self.last
        self.last = numbers


def cells(points: Iterable[int] = POINTS) -> Iterator[Cell]:
    """Return every kind of draw."""
    for values in itertools.product(FAULTS, DELAYS_S, TransferFormat, points):
        yield Cell(*values)


def draw(cell: Cell, traces: int) -> Count:
    """Take traces in a row, each at another place, from an instrument with the fault of a cell."""
    place = [0.0]
    scene = InstrumentScene(late_bit_s=cell.delay_s, late_memory_s=cell.delay_s)
    vna = SimulatedAnalyzer(
        PositionProbe(),
        lambda: AntennaPosition(place[0], 0.0, 0.0),
        Clock(),
        scene,
        AnalyzerOptions(seconds_per_point=SECONDS_PER_POINT),
    )
    if cell.delay_s:
        vna.faults.set(cell.fault)
    vna.start()
    parameters = VnaParameters(transfer_format=cell.transfer, seconds_per_point=SECONDS_PER_POINT)
    deadline = RequestDeadline(Clock())
    analyzer = Ms2026c(
        lambda address: connect(address, LinkLimits(), vna.server.port), parameters, deadline
    )
    driver = VNADriver(analyzer, parameters, deadline, lambda _text: None)
    count = Count()
    try:
        driver.connect_to_vna(HOST)
        driver.set_frequency_sweep(SweepSettings(600e6, 6e9, cell.points))
        for number in range(traces):
            # Single precision has it exactly.
            place[0] = number + 1.0
            count.note(_confirmed(driver, count), place[0])
    finally:
        driver.shut_down()
        vna.stop()
    return count


def drawn(chosen: Sequence[Cell], traces: int, workers: int) -> List[Count]:
    """Draw so many traces of each cell, several instruments at a time."""
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda cell: draw(cell, traces), chosen))


def _confirmed(driver: VNADriver, count: Count) -> Sweep:
    for _ in range(MOST_REPEATS):
        number, sweep = driver.take_sweep()
        try:
            driver.confirm(number)
            return sweep
        except UNCONFIRMED:
            count.repeated += 1
    raise AssertionError(f"{MOST_REPEATS} sweeps in a row were not confirmed")
