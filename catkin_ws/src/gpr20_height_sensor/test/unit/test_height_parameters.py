"""The curve passes through the data sheet's values and falls with the voltage."""

from __future__ import annotations

import doctest
import math
from pathlib import Path

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED
from gpr20_common.mid.codec import record_from
from gpr20_height_sensor.mid.height_parameters import HeightParameters

README = Path(__file__).parents[2] / "README.md"


@each_case("voltage_v, distance_m", [(0.4, 0.80), (2.3, 0.10)])
def test_passes_through_the_typical_values_of_the_data_sheet(voltage_v, distance_m):
    assert HeightParameters().distances_m(np.array([voltage_v]))[0] == pytest.approx(
        distance_m, 1e-4
    )


@given(st.floats(0.01, 3.3), st.floats(0.01, 3.3))
def test_a_higher_voltage_is_nearer(one_v, other_v):
    low, high = sorted((one_v, other_v))
    distances_m = HeightParameters().distances_m(np.array([low, high]))
    assert distances_m[0] >= distances_m[1]


WRONG = {
    "scale_m": (0.0, math.nan),
    "exponent": (-1.0,),
    "min_distance_m": (0.0, 0.9),
    "max_distance_m": (math.inf,),
    "samples": (2,),
    "reference_voltage_v": (0.0, 33.0),
    "update_period_s": (-0.1, 1e300),
    "max_spread_m": (math.nan, 1e300),
    "height_offset_m": (5.0,),
    "frozen_readings": (-1, 29),
    "spi_device": (32,),
    "channel": (8,),
    "spi_speed_hz": (5_000_000,),
}


@each_case("name, value", [(name, value) for name in WRONG for value in WRONG[name]])
def test_parameters_that_make_no_sense_are_refused(name, value):
    with raises_fault((NOT_ALLOWED, CONFIGURATION), f"{value:.12g}", error=InvalidValueError):
        record_from(HeightParameters, {name: value}, "height_sensor")


def test_the_examples_of_the_readme_do_what_they_say():
    result = doctest.testfile(str(README), module_relative=False, encoding="utf-8")
    assert result.attempted > 0 and result.failed == 0
