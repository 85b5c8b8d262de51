"""The driver and the simulated instrument over a real VXI-11 socket.

The medium answers with the number of the sweep as real part and the true place of the
antennas as imaginary part of each point.
"""

from __future__ import annotations

import threading
import time
from typing import Callable, Iterator, List, Tuple

import pytest

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, SimulatedAnalyzer
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe
from gpr20_simulator.mid.world.scene import InstrumentScene
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, Vxi11Transport, connect
from gpr20_vna_acquisition.mid.block_parser import TransferFormat
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

HOST = "127.0.0.1"
LIMITS = LinkLimits(connect_s=1.0, answer_s=1.0)
SECONDS_PER_POINT = 100e-6
SWEEP = SweepSettings(600e6, 6e9, 301)


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


def instrument(robot: Robot, description: InstrumentScene) -> SimulatedAnalyzer:
    options = AnalyzerOptions(seconds_per_point=SECONDS_PER_POINT)
    return SimulatedAnalyzer(PositionProbe(), robot.position, Clock(), description, options)


@pytest.fixture
def bench() -> Iterator[Tuple[Robot, SimulatedAnalyzer]]:
    robot = Robot()
    vna = instrument(robot, InstrumentScene())
    vna.start()
    yield robot, vna
    vna.stop()


def driver_of(vna: SimulatedAnalyzer, **parameters) -> VNADriver:
    def open_link(address: str) -> Vxi11Transport:
        return connect(address, LIMITS, vna.server.port)

    values = VnaParameters(retry_pause_s=0.01, seconds_per_point=SECONDS_PER_POINT, **parameters)
    driver = driver_at(open_link, values)
    driver.set_frequency_sweep(SWEEP)
    return driver


def driver_at(open_link: Callable[[str], Vxi11Transport], values: VnaParameters) -> VNADriver:
    deadline = RequestDeadline(Clock())
    analyzer = Ms2026c(open_link, values, deadline)
    driver = VNADriver(analyzer, values, deadline, lambda text: None)
    driver.connect_to_vna(HOST)
    return driver


@pytest.mark.parametrize("transfer", list(TransferFormat))
def test_no_point_of_a_sweep_was_measured_before_the_antennas_stopped(bench, transfer):
    robot, vna = bench
    driver = driver_of(vna, transfer_format=transfer)
    for _ in range(3):
        robot.stopped_at_mm = None
        moving = driver.get_trace()
        assert len(set(moving.s21_imag)) > 3, "the test is void: nothing moved during the sweep"
        robot.stop()
        resting = driver.get_trace()
        assert set(resting.s21_imag) == {robot.stopped_at_mm}
        assert len(set(resting.s21_real)) == 1 and resting.s21_real[0] > moving.s21_real[0]


def test_an_instrument_switched_back_to_continuous_gives_no_sweep_that_ran_before(bench):
    robot, vna = bench
    driver = driver_of(vna, lock_instrument=False)
    other_hand = connect(HOST, LIMITS, vna.server.port)
    for _ in range(3):
        robot.stopped_at_mm = None
        other_hand.write(":INIT:CONT ON")
        before = vna.sweeper.sweep_number
        deadline = time.monotonic() + 2.0
        while vna.sweeper.sweep_number == before:
            assert time.monotonic() < deadline, "the instrument does not sweep continuously"
            time.sleep(0.001)
        robot.stop()
        running = vna.sweeper.sweep_number
        sweep = driver.get_trace()
        assert set(sweep.s21_imag) == {robot.stopped_at_mm}
        assert len(set(sweep.s21_real)) == 1 and sweep.s21_real[0] > running
    other_hand.close()


@pytest.mark.parametrize(
    "comma, newline, digits, transfer",
    [
        (True, True, 0, TransferFormat.ASCII),
        (True, False, 9, TransferFormat.ASCII),
        (False, True, 9, TransferFormat.ASCII),
        (False, True, 0, TransferFormat.REAL32),
        (False, False, 9, TransferFormat.REAL32),
    ],
)
def test_reads_the_block_however_the_instrument_dresses_it(comma, newline, digits, transfer):
    robot = Robot()
    robot.stop()
    description = InstrumentScene(
        trailing_comma=comma, trailing_newline=newline, header_digits=digits
    )
    vna = instrument(robot, description)
    vna.start()
    try:
        sweep = driver_of(vna, transfer_format=transfer).get_trace()
        assert len(sweep.s21_imag) == SWEEP.points
        assert set(sweep.s21_imag) == {robot.stopped_at_mm}
    finally:
        vna.stop()


@pytest.mark.parametrize("accuracy", [CalibrationStatus.NONE, CalibrationStatus.LOW])
def test_calibration_status_is_the_instruments(accuracy):
    vna = instrument(Robot(), InstrumentScene(calibration_accuracy=int(accuracy)))
    vna.start()
    try:
        assert driver_of(vna).check_calibration_status() is accuracy
    finally:
        vna.stop()


@pytest.mark.parametrize(
    "fault",
    ["HANG", "DROP", "SILENT", "LATE", "TRUNCATE", "NAN", "GARBAGE", "STALE", "WRONG_IDENTITY"],
)
def test_after_any_fault_the_next_sweep_is_new_and_no_link_is_left_over(bench, fault):
    robot, vna = bench
    robot.stop()
    driver = driver_of(vna)
    first = driver.get_trace()
    vna.faults.set(fault, 1)
    if fault == "WRONG_IDENTITY":
        # Only a new link asks for the identity.
        vna.faults.set("DROP", 1)
    second = driver.get_trace()
    assert second.s21_real[0] > first.s21_real[0] and len(set(second.s21_real)) == 1
    driver.disconnect_from_vna()
    deadline = time.monotonic() + 2.0
    while vna.server.link_count:
        assert time.monotonic() < deadline, "links are left on the instrument"
        time.sleep(0.005)


def test_an_instrument_that_was_switched_off_and_on_is_set_up_again():
    robot = Robot()
    robot.stop()
    vnas: List[SimulatedAnalyzer] = [instrument(robot, InstrumentScene())]
    vnas[0].start()
    driver = driver_at(
        lambda address: connect(address, LIMITS, vnas[-1].server.port),
        VnaParameters(retry_pause_s=0.1, seconds_per_point=SECONDS_PER_POINT),
    )
    driver.set_frequency_sweep(SWEEP)
    driver.get_trace()
    vnas[0].stop()

    def switch_on() -> None:
        vnas.append(instrument(robot, InstrumentScene()))
        vnas[-1].start()

    timer = threading.Timer(0.3, switch_on)
    timer.start()
    try:
        # The fresh instrument counts from the start again; the settings are its defaults.
        sweep = driver.get_trace()
        assert len(sweep.s21_real) == SWEEP.points
        assert driver.state.repeats >= 1
    finally:
        timer.join()
        driver.disconnect_from_vna()
        vnas[-1].stop()
