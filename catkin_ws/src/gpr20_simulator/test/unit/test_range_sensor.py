"""The simulated sensor shows the true height, its noise and its faults."""

from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case

from gpr20_common.low.clock import Clock
from gpr20_height_sensor.errors import SensorRangeError, SensorStuckError
from gpr20_height_sensor.low.adc_interface import AdcInterface
from gpr20_height_sensor.mid.height_driver import HeightDriver
from gpr20_height_sensor.mid.height_parameters import HeightParameters
from gpr20_simulator.low.shared_state import AdcFault
from gpr20_simulator.low.spi import SimulatedSpi
from gpr20_simulator.mid.world.range_sensor import RangeSensor, sensor_voltage_v
from gpr20_simulator.mid.world.scene import Adc


class NoClock(Clock):
    def sleep_until_s(self, deadline_s):
        pass

    def wait_s(self, event, timeout_s):
        return event.is_set()


def sensor_at(height_m, fault=AdcFault.NONE, adc=None):
    return RangeSensor(adc or Adc(), lambda: height_m, lambda: fault)


def driver_of(sensor):
    adc = AdcInterface(SimulatedSpi(sensor.code), 0)
    return HeightDriver(adc, HeightParameters(), NoClock(), lambda: 0)


@each_case(
    "distance_m, voltage_v", [(0.80, 0.4), (0.10, 2.3)]
)  # fmt: skip
def test_the_output_is_that_of_the_data_sheet(distance_m, voltage_v):
    assert sensor_voltage_v(distance_m) == pytest.approx(voltage_v)


def test_the_output_falls_on_both_sides_of_its_peak():
    distances_m = np.linspace(0.0, 1.5, 301)
    voltages_v = np.array([sensor_voltage_v(d) for d in distances_m])
    peak = int(voltages_v.argmax())
    assert 0.05 < distances_m[peak] < 0.10 and voltages_v[peak] <= 3.1
    assert (np.diff(voltages_v[: peak + 1]) > 0).all() and (np.diff(voltages_v[peak:]) < 0).all()


@each_case("height_m", [0.12, 0.20, 0.30, 0.40])
def test_the_driver_finds_the_true_height_within_5_mm(height_m):
    assert driver_of(sensor_at(height_m)).take_measurement().height_m == pytest.approx(
        height_m, abs=0.005
    )


def test_the_noise_has_the_level_of_the_scene_and_can_be_repeated():
    adc = Adc(noise_v=0.05, seed=7)
    sensor, again = sensor_at(0.2, adc=adc), sensor_at(0.2, adc=adc)
    codes = np.array([sensor.code(0) for _ in range(2000)])
    assert codes.std() * 3.3 / 1024 == pytest.approx(0.05, rel=0.1)
    assert codes.tolist() == [again.code(0) for _ in range(2000)]


def test_a_stuck_converter_is_noticed():
    with pytest.raises(SensorStuckError):
        driver_of(sensor_at(0.2, AdcFault.STUCK)).take_measurement()


def test_a_sensor_out_of_its_range_is_noticed():
    with pytest.raises(SensorRangeError):
        driver_of(sensor_at(0.2, AdcFault.OUT_OF_RANGE)).take_measurement()


def test_other_channels_are_grounded():
    assert sensor_at(0.2).code(1) == 0


@each_case("height_m", [0.0, -0.1, 0.07, 100.0])
def test_any_height_gives_a_code_of_the_converter(height_m):
    assert 0 <= sensor_at(height_m).code(0) <= 1023
