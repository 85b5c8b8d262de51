"""A simulated instrument in this process, and a good class for it."""

from __future__ import annotations

import threading
import time
from typing import List, Optional

import numpy as np

from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import verbatim
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition import errors

ADDRESS = "127.0.0.1"
MAKER, MODEL = "Toy", "T1"
PER_POINT_HZ_S = 1.0
DELAY_S = 3e-9


class ToyInstrument:
    """What all links to the instrument have in common.

    Attributes:
        identity: Its identification.
        settings: What it measures.
        level: Magnitude of what it sees.
        sweeps: How many it has made.
        made: The objects of classes for it, in the order in which they were made.
    """

    def __init__(self) -> None:
        self.identity = f"{MAKER},{MODEL},1234567,1.0"
        self.settings = SweepSettings(1e6, 2e6, 11, AnalyzerSettings(100_000.0, 1))
        self.level = 0.1
        self.sweeps = 0
        self.made: List[ToyVna] = []

    def duration_s(self) -> float:
        return self.settings.points * PER_POINT_HZ_S / self.settings.analyzer.if_bandwidth_hz

    def sweep(self) -> np.ndarray:
        time.sleep(self.duration_s())
        self.sweeps += 1
        noise = np.random.default_rng(self.sweeps).normal(size=(2, self.settings.points))
        seen = self.level * np.exp(-2j * np.pi * self.settings.frequencies_hz() * DELAY_S)
        return seen + 1e-5 * (noise[0] + 1j * noise[1])


class ToyVna:
    """A good class; it blocks at the call that `blocks` names, until `freed` is set."""

    remarks = ()
    trace_duration_s: Optional[float] = None

    def __init__(self, parameters, deadline, instrument: ToyInstrument, blocks: str = "") -> None:
        self.parameters, self.deadline, self.instrument = parameters, deadline, instrument
        self.blocks, self.blocking, self.freed = blocks, threading.Event(), threading.Event()
        self.linked = False
        self.identity = ""
        self.accepted: Optional[SweepSettings] = None
        instrument.made.append(self)

    def block(self, call: str) -> None:
        if self.blocks == call:
            self.blocking.set()
            self.freed.wait()

    def connect(self, address: str) -> None:
        self.block("connect")
        self.linked = True

    def identify(self) -> str:
        self.check_link()
        self.block("identify")
        identity = self.instrument.identity
        self.parameters.check_identity(identity)
        if identity != self.identity:
            self.accepted = None
        self.identity = identity
        return identity

    def check_sweep(self, settings: SweepSettings) -> None:
        self.block("check_sweep")
        self.parameters.check_sweep(settings)

    def configure(self, settings: SweepSettings) -> SweepSettings:
        self.check_link()
        self.block("configure")
        old, wanted = self.instrument.settings.analyzer, settings.analyzer
        bandwidth_hz = wanted.if_bandwidth_hz or old.if_bandwidth_hz
        analyzer = AnalyzerSettings(bandwidth_hz, wanted.averages or old.averages)
        self.accepted = self.instrument.settings = SweepSettings(
            settings.start_frequency_hz, settings.stop_frequency_hz, settings.points, analyzer
        )
        self.trace_duration_s = self.instrument.duration_s()
        return self.accepted

    def sweep(self) -> Sweep:
        self.check_link()
        if self.accepted is None:
            raise errors.not_configured()
        self.block("sweep")
        started_us = time_of_day_us()
        return self.as_sweep(self.instrument.sweep(), started_us)

    def as_sweep(self, data: np.ndarray, started_us: int) -> Sweep:
        frequencies_hz, analyzer = self.accepted.frequencies_hz(), self.accepted.analyzer
        real, imag = data.real.copy(), data.imag.copy()
        return Sweep(frequencies_hz, real, imag, started_us, time_of_day_us(), (), analyzer)

    def confirm(self) -> None:
        self.check_link()
        if self.accepted is None:
            raise errors.not_configured()
        self.block("confirm")
        if self.instrument.settings != self.accepted:
            raise errors.settings_changed(verbatim(str(self.instrument.settings)))

    def calibration(self) -> CalibrationStatus:
        self.check_link()
        self.block("calibration")
        return CalibrationStatus.HIGH

    def release(self) -> None:
        self.block("release")

    def disconnect(self) -> None:
        self.block("disconnect")
        self.linked = False

    def check_link(self) -> None:
        self.deadline.check()
        if not self.linked:
            raise errors.not_connected()
