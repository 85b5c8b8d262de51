"""A driver at a fake instrument."""

from __future__ import annotations

from typing import List

from fake_vna import FakeClock, FakeVna

from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

ADDRESS = "192.168.1.10"
SWEEP = SweepSettings(600e6, 6e9, 11)
STARTED_US = 1_800_000_000_123_456


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
            self.warnings.append,
            lambda: STARTED_US,
        )

    def configured(self) -> Bench:
        self.driver.connect_to_vna(ADDRESS)
        self.driver.set_frequency_sweep(SWEEP)
        self.driver.set_trace()
        return self
