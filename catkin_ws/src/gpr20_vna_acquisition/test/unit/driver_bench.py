"""A driver at a fake instrument."""

from __future__ import annotations

from dataclasses import replace
from typing import List

from fake_vna import FakeClock, FakeVna

from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

ADDRESS = "192.168.1.10"
SWEEP = SweepSettings(600e6, 6e9, 11)
# As the instrument confirms it: with its own values of what was left to it.
ACCEPTED = replace(SWEEP, analyzer=AnalyzerSettings(10_000.0, 1, "HIGH"))
STARTED_US = 1_800_000_000_123_456


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
