"""A height is a robust value of fresh readings, or an error with the reason."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.low.clock import Clock
from gpr20_height_sensor import faults
from gpr20_height_sensor.errors import (
    HeightError,
    HeightStoppedError,
)
from gpr20_height_sensor.mid.height_driver import HeightDriver
from gpr20_height_sensor.mid.height_parameters import HeightParameters
from gpr20_survey.faults import NO_GROUND, SENSOR_FAILED

PARAMETERS = HeightParameters(samples=5)
NOW_US = 1_700_000_000_000_000


class FakeClock(Clock):
    def __init__(self):
        self.time_s = 10.0

    def now_s(self):
        return self.time_s

    def wait_s(self, event, timeout_s):
        if not event.is_set():
            self.time_s += timeout_s
        return event.is_set()


class FakeAdc:
    """Gives codes in turn and notes when it was asked."""

    def __init__(self, codes, clock):
        self.codes = list(codes)
        self.clock = clock
        self.times_s = []
        self.closed = False

    def read_code(self):
        self.times_s.append(self.clock.time_s)
        code = self.codes.pop(0)
        if isinstance(code, Exception):
            raise code
        return code

    def close(self):
        self.closed = True


def code_at(distance_m):
    """The code of a typical sensor, from the data sheet's two points and not from the driver."""
    exponent = np.log(2.3 / 0.4) / np.log(0.8 / 0.1)
    return round(0.4 * (distance_m / 0.8) ** -exponent / 3.3 * 1024)


def driver_with(codes, parameters=PARAMETERS):
    clock = FakeClock()
    adc = FakeAdc(codes, clock)
    return HeightDriver(adc, parameters, clock, lambda: NOW_US), adc


@each_case("distance_m", [0.11, 0.20, 0.50, 0.75])
def test_measures_the_distance_within_the_converters_resolution(distance_m):
    driver, _ = driver_with([code_at(distance_m)] * 5)
    measured = driver.take_measurement()
    assert measured.height_m == pytest.approx(distance_m, abs=0.0005 + 0.008 * distance_m**2)
    assert (measured.spread_m, measured.measured_us) == (0.0, NOW_US)


def test_the_offset_between_sensor_and_antennas_is_added():
    parameters = HeightParameters(height_offset_m=-0.05)
    driver, _ = driver_with([code_at(0.25)] * 5, parameters)
    assert driver.take_measurement().height_m == pytest.approx(0.20, abs=0.001)


def test_every_reading_is_of_another_period_that_began_after_the_request():
    driver, adc = driver_with([code_at(0.2)] * 5)
    requested_s = adc.clock.time_s
    driver.take_measurement()
    period_s = PARAMETERS.update_period_s
    assert adc.times_s[0] - requested_s >= 2 * period_s - 1e-9
    assert (np.diff(adc.times_s) >= period_s - 1e-9).all()


@each_case("bad", [[1], [400], [900], [1022], [0, 0]])
def test_bad_readings_in_the_minority_do_not_move_the_height(bad):
    good = [code_at(0.2)] * (5 - len(bad))
    driver, _ = driver_with([*good[:1], *bad, *good[1:]])
    assert driver.take_measurement().height_m == pytest.approx(0.2, abs=0.001)


@each_case("rail", [0, 1023])
@each_case("others", [0, 1, 2])
def test_a_reading_stuck_at_a_rail_is_no_height(rail, others):
    driver, _ = driver_with([rail] * (5 - others) + [code_at(0.2)] * others)
    with raises_fault(SENSOR_FAILED, rail, error=HeightError):
        driver.take_measurement()


@each_case("distance_m", [0.085, 0.09, 0.85, 1.6])
def test_a_distance_that_the_sensor_cannot_measure_is_no_height(distance_m):
    driver, _ = driver_with([code_at(distance_m)] * 5)
    with raises_fault(NO_GROUND, 0.1, 0.8, error=HeightError):
        driver.take_measurement()


def test_scattered_readings_are_no_height_however_few_agree():
    driver, _ = driver_with([code_at(d) for d in (0.15, 0.2, 0.3, 0.45, 0.6)])
    with raises_fault(SENSOR_FAILED, error=HeightError):
        driver.take_measurement()


def test_the_spread_of_normal_noise_is_its_standard_deviation():
    samples = 999
    random = np.random.default_rng(1)
    distances_m = 0.2 + random.normal(0.0, 0.004, samples)
    parameters = HeightParameters(samples=samples)
    driver, _ = driver_with([code_at(d) for d in distances_m], parameters)
    measured = driver.take_measurement()
    assert measured.spread_m == pytest.approx(0.004, rel=0.1)
    assert measured.height_m == pytest.approx(0.2, abs=0.0005)


FROZEN = HeightParameters(samples=5, frozen_readings=30)


def test_the_very_same_code_for_ever_is_no_height_and_another_code_ends_that():
    good = code_at(0.2)
    driver, _ = driver_with([good] * 35 + [good + 1] + [good] * 4, FROZEN)
    for _ in range(5):
        driver.take_measurement()
    for count in (30, 35):
        with raises_fault(faults.FROZEN, count, error=HeightError):
            driver.take_measurement()
    assert driver.take_measurement().height_m == pytest.approx(0.2, abs=0.001)


@each_case("steps, frozen_readings", [([0, 0, 0, 0, 1], 30), ([0], 0)])
def test_readings_with_the_least_noise_are_never_stuck_and_the_check_can_be_switched_off(
    steps, frozen_readings
):
    codes = [code_at(0.2) + step for step in steps] * (200 // len(steps))
    driver, _ = driver_with(codes, HeightParameters(samples=5, frozen_readings=frozen_readings))
    for _ in range(40):
        driver.take_measurement()


@given(st.lists(st.integers(0, 1023), min_size=5, max_size=5))
def test_any_readings_give_a_height_in_range_or_our_error(codes):
    driver, _ = driver_with(codes)
    try:
        measured = driver.take_measurement()
    except HeightError:
        return
    assert 0.10 <= measured.height_m <= 0.80
    assert 0.0 <= measured.spread_m <= PARAMETERS.max_spread_m


def test_a_shutdown_ends_a_measurement_and_gives_the_bus_back():
    class RealWait(FakeClock):
        def wait_s(self, event, timeout_s):
            waiting.set()
            return event.wait(30.0)

    waiting = threading.Event()
    clock = RealWait()
    adc = FakeAdc([], clock)
    driver = HeightDriver(adc, PARAMETERS, clock, lambda: NOW_US)
    with ThreadPoolExecutor() as pool:
        measuring = pool.submit(driver.take_measurement)
        assert waiting.wait(30.0)
        driver.shut_down()
        assert isinstance(measuring.exception(30.0), HeightStoppedError)
    assert adc.closed and not adc.times_s


def test_two_measurements_at_once_do_not_wait_for_each_other():
    both_reading = threading.Barrier(2, timeout=30.0)

    class MeetingAdc:
        def read_code(self):
            both_reading.wait()
            return code_at(0.2)

    driver = HeightDriver(MeetingAdc(), PARAMETERS, FakeClock(), lambda: NOW_US)
    with ThreadPoolExecutor(2) as pool:
        for one in [pool.submit(driver.take_measurement) for _ in range(2)]:
            one.result(30.0)
