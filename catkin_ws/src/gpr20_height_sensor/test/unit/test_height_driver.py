"""A height is a robust value of fresh readings, or an error with the reason."""

from __future__ import annotations

import contextlib
import math
import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED
from gpr20_common.low.clock import Clock
from gpr20_common.mid.codec import record_from
from gpr20_height_sensor import faults
from gpr20_height_sensor.faults import HeightError, HeightStoppedError
from gpr20_height_sensor.height_driver import HeightDriver, HeightParameters
from gpr20_survey.faults import NO_GROUND, SENSOR_FAILED

PARAMETERS = HeightParameters(samples=5)
NOW_US = 1_700_000_000_000_000


class Sensor(Clock):
    """Gives codes in turn and notes when; its time passes only in waits."""

    def __init__(self, codes):
        self.codes, self.times_s, self.time_s, self.closed = list(codes), [], 10.0, False

    def now_s(self):
        return self.time_s

    def wait_s(self, event, timeout_s):
        self.time_s += timeout_s
        return event.is_set()

    def read_code(self):
        self.times_s.append(self.time_s)
        return self.codes.pop(0)

    def close(self):
        self.closed = True


def code_at(distance_m):
    """The code of a typical sensor, from the data sheet's two points and not from the driver."""
    exponent = np.log(2.3 / 0.4) / np.log(0.8 / 0.1)
    return round(0.4 * (distance_m / 0.8) ** -exponent / 3.3 * 1024)


GROUND = code_at(0.2)


def driver_with(codes, parameters=PARAMETERS):
    sensor = Sensor(codes)
    return HeightDriver(sensor, parameters, sensor, lambda: NOW_US), sensor


@given(st.floats(0.11, 0.75), st.floats(-0.05, 0.05))
def test_a_height_is_the_distance_within_the_converters_resolution_and_the_offset(
    distance_m, offset_m
):
    parameters = HeightParameters(height_offset_m=offset_m)
    measured = driver_with([code_at(distance_m)] * 5, parameters)[0].take_measurement()
    allowed_m = 0.0005 + 0.008 * distance_m**2
    assert measured.height_m == pytest.approx(distance_m + offset_m, abs=allowed_m)
    assert (measured.spread_m, measured.measured_us) == (0.0, NOW_US)


def test_every_reading_is_of_another_period_that_began_after_the_request():
    driver, sensor = driver_with([GROUND] * 5)
    requested_s, period_s = sensor.time_s, PARAMETERS.update_period_s
    driver.take_measurement()
    assert sensor.times_s[0] - requested_s >= 2 * period_s - 1e-9
    assert (np.diff(sensor.times_s) >= period_s - 1e-9).all()


@each_case(
    "codes, fault",
    [
        *(
            ([rail] * (5 - others) + [GROUND] * others, SENSOR_FAILED)
            for rail in (0, 1023)
            for others in range(3)
        ),
        *(([code_at(one)] * 5, NO_GROUND) for one in (0.085, 0.09, 0.85, 1.6)),
        ([code_at(one) for one in (0.15, 0.2, 0.3, 0.45, 0.6)], SENSOR_FAILED),
    ],
)
def test_readings_at_a_rail_out_of_range_or_scattered_are_no_height(codes, fault):
    with raises_fault(fault, error=HeightError):
        driver_with(codes)[0].take_measurement()


@given(st.lists(st.integers(0, 1023), max_size=2), st.permutations(range(5)))
def test_bad_readings_in_the_minority_do_not_move_the_height(bad, order):
    codes = [*bad, *[GROUND] * (5 - len(bad))]
    measured = driver_with(codes[one] for one in order)[0].take_measurement()
    assert measured.height_m == pytest.approx(0.2, abs=0.001)


def test_the_spread_of_normal_noise_is_its_standard_deviation():
    distances_m = 0.2 + np.random.default_rng(1).normal(0.0, 0.004, 999)
    parameters = HeightParameters(samples=999)
    measured = driver_with(map(code_at, distances_m), parameters)[0].take_measurement()
    assert measured.spread_m == pytest.approx(0.004, rel=0.1)
    assert measured.height_m == pytest.approx(0.2, abs=0.0005)


@given(st.lists(st.integers(1, 70), min_size=1, max_size=6), st.sampled_from([0, 30]))
def test_a_sensor_that_reads_one_code_for_too_long_is_stuck_until_it_reads_another(lengths, limit):
    codes = [GROUND + turn % 2 for turn, length in enumerate(lengths) for _ in range(length)]
    driver, _ = driver_with(codes, HeightParameters(samples=5, frozen_readings=limit))
    for end in range(5, len(codes) + 1, 5):
        stuck = 0 < limit <= end and len(set(codes[end - limit : end])) == 1
        with raises_fault(faults.FROZEN) if stuck else contextlib.nullcontext():
            driver.take_measurement()


@given(st.lists(st.integers(0, 1023), min_size=5, max_size=5))
def test_any_readings_give_a_height_in_range_or_our_error(codes):
    with contextlib.suppress(HeightError):
        measured = driver_with(codes)[0].take_measurement()
        assert 0.10 <= measured.height_m <= 0.80
        assert 0.0 <= measured.spread_m <= PARAMETERS.max_spread_m


def test_a_shutdown_ends_a_measurement_and_gives_the_bus_back():
    sensor = Sensor([])
    driver = HeightDriver(sensor, HeightParameters(update_period_s=1.0), Clock())
    with ThreadPoolExecutor() as pool:
        measuring = pool.submit(driver.take_measurement)
        driver.shut_down()
        assert isinstance(measuring.exception(30.0), HeightStoppedError)
    assert sensor.closed and not sensor.times_s


def test_two_measurements_at_once_do_not_wait_for_each_other():
    both_reading = threading.Barrier(2, timeout=30.0)

    def read_code():
        both_reading.wait()
        return GROUND

    adc = SimpleNamespace(read_code=read_code)
    driver = HeightDriver(adc, PARAMETERS, Sensor([]), lambda: NOW_US)
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda _number: driver.take_measurement(), range(2)))


WRONG = {
    "scale_m": (0.0, math.nan),
    "min_distance_m": (0.0, 0.9),
    "max_distance_m": (math.inf,),
    "samples": (2,),
    "update_period_s": (-0.1, 1e300),
    "frozen_readings": (-1, 29),
    "channel": (8,),
}


@each_case("name, value", [(name, value) for name in WRONG for value in WRONG[name]])
def test_parameters_that_make_no_sense_are_refused(name, value):
    with raises_fault((NOT_ALLOWED, CONFIGURATION), f"{value:.12g}", error=InvalidValueError):
        record_from(HeightParameters, {name: value}, "height_sensor")
