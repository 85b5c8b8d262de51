"""A driver at a fake instrument."""

from __future__ import annotations

from typing import List

from fake_vna import FakeClock, FakeVna

from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.low.time_of_day import TimeOfDay
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

ADDRESS = "192.168.1.10"
SWEEP = SweepSettings(600e6, 6e9, 11)
WALL_NS = 1_800_000_000_123_456_789


class Bench:
    """A driver at a fake instrument."""

    def __init__(self, **parameters) -> None:
        self.clock = FakeClock()
        self.vna = FakeVna(self.clock)
        self.warnings: List[str] = []
        self.driver = VNADriver(
            self.vna.connect,
            VnaParameters(**parameters),
            self.clock,
            TimeOfDay(lambda: WALL_NS, self.clock.now_ns),
            self.warnings.append,
        )

    def configured(self) -> Bench:
        self.driver.connect(ADDRESS)
        self.driver.configure(SWEEP)
        return self
