"""The driver and the simulated instrument over a real VXI-11 socket."""

from __future__ import annotations

import doctest
from pathlib import Path

import pytest
from fault_kit import raises_fault
from hostile_server import HOST, PATIENT, wait_until

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, SimulatedAnalyzer
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe
from gpr20_simulator.mid.world.scene import Scene
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.low.vxi11_transport import connect
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

README = Path(__file__).resolve().parents[2] / "README.md"
SECONDS_PER_POINT = 100e-6
SWEEP = SweepSettings(600e6, 6e9, 301)


@pytest.fixture
def switched_on():
    """Starts a simulated analyzer, and stops it in the end."""
    made = []

    def start(medium, options):
        place = AntennaPosition(100.0, 100.0, 0.0)
        made.append(SimulatedAnalyzer(medium, lambda: place, Clock(), Scene().instrument, options))
        made[-1].start()
        return made[-1]

    yield start
    for one in made:
        one.stop()


@pytest.fixture
def vna(switched_on) -> SimulatedAnalyzer:
    return switched_on(PositionProbe(), AnalyzerOptions(SECONDS_PER_POINT))


def driver_of(vna: SimulatedAnalyzer, **parameters) -> VNADriver:
    values = VnaParameters(
        retry_pause_s=0.01, seconds_per_point=SECONDS_PER_POINT, display_settle_s=0.0, **parameters
    )
    deadline = RequestDeadline(Clock())
    analyzer = Ms2026c(lambda address: connect(address, PATIENT, vna.server.port), values, deadline)
    driver = VNADriver(analyzer, values, deadline, lambda text: None)
    driver.connect_to_vna(HOST)
    driver.set_frequency_sweep(SWEEP)
    return driver


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


def test_the_example_of_the_readme_gives_what_it_shows(switched_on):
    vna = switched_on(Ground(Scene()), AnalyzerOptions())
    results = doctest.testfile(str(README), module_relative=False, globs={"port": vna.server.port})
    assert results.attempted > 10 and results.failed == 0
