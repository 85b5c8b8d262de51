"""The driver and the simulated instrument over a real VXI-11 socket.

The medium answers with the number of the sweep as real part and the true place of the
antennas as imaginary part of each point.
"""

from __future__ import annotations

import doctest
import time
from pathlib import Path
from typing import Iterator

import pytest
from fault_kit import raises_fault
from hostile_server import wait_until

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.simulated_analyzer import (
    AnalyzerOptions,
    SimulatedAnalyzer,
    medium_by_name,
)
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe
from gpr20_simulator.mid.world.scene import InstrumentScene, Scene
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, connect
from gpr20_vna_acquisition.mid.block_parser import TransferFormat
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

README = Path(__file__).resolve().parents[2] / "README.md"
HOST = "127.0.0.1"
PATIENT = LinkLimits(30.0, 30.0)
SECONDS_PER_POINT = 100e-6
SWEEP = SweepSettings(600e6, 6e9, 301)
LIMIT_S = 30.0


class Robot:
    """Antennas that move until they are stopped."""

    def __init__(self) -> None:
        self.stopped_at_mm = None
        self._origin_s = time.monotonic()

    def position(self) -> AntennaPosition:
        if self.stopped_at_mm is not None:
            return AntennaPosition(self.stopped_at_mm, 0.0, 0.0)
        moved_mm = (time.monotonic() - self._origin_s) * 100.0
        return AntennaPosition(float(int(moved_mm * 16)) / 16, 0.0, 0.0)

    def stop(self) -> None:
        self.stopped_at_mm = self.position().x_mm


@pytest.fixture
def robot() -> Robot:
    return Robot()


@pytest.fixture
def vna(robot) -> Iterator[SimulatedAnalyzer]:
    options = AnalyzerOptions(seconds_per_point=SECONDS_PER_POINT)
    one = SimulatedAnalyzer(PositionProbe(), robot.position, Clock(), InstrumentScene(), options)
    one.start()
    yield one
    one.stop()


def driver_of(vna: SimulatedAnalyzer, **parameters) -> VNADriver:
    values = VnaParameters(
        retry_pause_s=0.01,
        seconds_per_point=SECONDS_PER_POINT,
        display_settle_s=0.0,
        max_level_db=90.0,
        same_points=4001,
        duration_tolerance_s=LIMIT_S,
        **parameters,
    )
    deadline = RequestDeadline(Clock())
    analyzer = Ms2026c(lambda address: connect(address, PATIENT, vna.server.port), values, deadline)
    driver = VNADriver(analyzer, values, deadline, lambda text: None)
    driver.connect_to_vna(HOST)
    driver.set_frequency_sweep(SWEEP)
    return driver


@pytest.mark.parametrize("transfer", list(TransferFormat))
def test_no_point_of_a_sweep_was_measured_before_the_antennas_stopped(robot, vna, transfer):
    driver = driver_of(vna, transfer_format=transfer)
    for _ in range(3):
        robot.stopped_at_mm = None
        moving = driver.get_trace()
        assert len(set(moving.s21_imag)) > 1, "the test is void: nothing moved during the sweep"
        robot.stop()
        resting = driver.get_trace()
        assert set(resting.s21_imag) == {robot.stopped_at_mm}
        assert len(set(resting.s21_real)) == 1 and resting.s21_real[0] > moving.s21_real[0]


def test_no_other_program_can_use_the_instrument_until_it_is_released(vna):
    driver = driver_of(vna)
    other = connect(HOST, PATIENT, vna.server.port)
    with raises_fault(faults.LOCKED, error=VnaConnectionError):
        other.write(":INIT:CONT ON")
    with raises_fault(faults.LOCKED, error=VnaConnectionError):
        driver_of(vna, request_timeout_s=0.5)
    # A lost link leaves no lock.
    vna.faults.set("DROP", 1)
    driver.confirm(driver.take_sweep()[0])
    driver.disconnect_from_vna()
    wait_until(lambda: not vna.server.link_count)
    driver_of(vna).disconnect_from_vna()


def test_the_example_of_the_readme_gives_what_it_shows():
    scene = Scene()
    place = AntennaPosition(100.0, 100.0, 0.0)
    medium = medium_by_name("scene", scene)
    vna = SimulatedAnalyzer(medium, lambda: place, Clock(), scene.instrument, AnalyzerOptions())
    vna.start()
    try:
        results = doctest.testfile(
            str(README), module_relative=False, globs={"port": vna.server.port}
        )
    finally:
        vna.stop()
    assert results.attempted > 10 and results.failed == 0
