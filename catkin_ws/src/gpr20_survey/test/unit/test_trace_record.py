from __future__ import annotations

import math

import numpy as np
import pytest
from trace_examples import STARTED_US, make_trace

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

NAN, INF = math.nan, math.inf


def with_value(value: float) -> np.ndarray:
    return np.array([1.0, 2.0, value, 4.0, 5.0])


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"format": "gpr20-trace/2"}, "format is 'gpr20-trace/2'"),
        ({"survey_id": ""}, "survey_id is ''"),
        ({"survey_id": "0F8FAD5B-D9CB-469F-A165-70867728950E"}, "lower case"),
        ({"sample_id": ""}, "sample_id"),
        ({"sample_id": "../../etc/passwd"}, "sample_id"),
        ({"sample_id": "a/b"}, "sample_id"),
        ({"sample_id": "a\n"}, "sample_id"),
        ({"sample_id": "a" * 129}, "sample_id"),
        ({"index": -1}, "index is -1"),
        ({"index": 1_000_000}, "index is 1000000"),
        ({"x_coord_mm": NAN}, "x_coord_mm is nan"),
        ({"y_coord_mm": INF}, "y_coord_mm is inf"),
        ({"z_coord_deg": -10_000.1}, "z_coord_deg"),
        ({"antennae_height_m": -INF}, "antennae_height_m"),
        ({"frequency_hz": with_value(2.0)}, "ascend"),
        ({"frequency_hz": with_value(NAN)}, "frequency_hz contains 1 NaN"),
        ({"frequency_hz": np.array([0.0, 1, 2, 3, 4])}, "above zero"),
        ({"frequency_hz": np.linspace(1, 2, 6)}, "s21_real has 5 values for 6"),
        ({"s21_real": with_value(NAN)}, "s21_real contains 1 NaN"),
        ({"s21_imag": with_value(-INF)}, "s21_imag contains 1 NaN or inf"),
        ({"s21_imag": np.ones(4)}, "s21_imag has 4 values for 5"),
        ({"s21_imag": np.ones(5, np.float32)}, "s21_imag"),
        ({"timestamp_us": 0}, "1970"),
        ({"sweep_started_us": 0}, "sweep_started is 1970"),
        ({"sweep_ended_us": 0}, "sweep_ended is 1970"),
        ({"sweep_ended_us": STARTED_US}, "lies before"),
        ({"quality": ("a\x00",)}, "printable"),
        ({"quality": ("\ud800",)}, "printable"),
        ({"quality": ("a" * 201,)}, "at most 200"),
        ({"quality": ("a",) * 33}, "33 remarks"),
        ({"analyzer": AnalyzerSettings(NAN)}, "if_bandwidth_hz is nan"),
        ({"analyzer": AnalyzerSettings(INF)}, "if_bandwidth_hz is inf"),
        ({"analyzer": AnalyzerSettings(-1.0)}, "if_bandwidth_hz is -1"),
        ({"analyzer": AnalyzerSettings(-0.0)}, "if_bandwidth_hz is -0"),
        ({"analyzer": AnalyzerSettings(2e9)}, "if_bandwidth_hz is 2000000000"),
        ({"analyzer": AnalyzerSettings(averages=-1)}, "averages is -1"),
        ({"analyzer": AnalyzerSettings(averages=1_000_001)}, "averages is 1000001"),
        ({"analyzer": AnalyzerSettings(output_power="A\n")}, "output_power"),
        ({"analyzer": AnalyzerSettings(output_power="A" * 33)}, "output_power"),
    ],
)
def test_a_wrong_value_is_refused_by_name(changes, reason):
    with pytest.raises(TraceRefusedError, match=reason):
        make_trace(**changes)


@pytest.mark.parametrize("points", [0, 1, 4002])
def test_too_few_or_too_many_points_are_refused(points):
    ramp = np.arange(1.0, points + 1.0)
    with pytest.raises(TraceRefusedError, match=f"there are {points} points"):
        make_trace(frequency_hz=ramp, s21_real=ramp, s21_imag=ramp)


@pytest.mark.parametrize("points", [2, 4001])
def test_the_smallest_and_the_largest_sweep_are_taken(points):
    ramp = np.arange(1.0, points + 1.0)
    trace = make_trace(frequency_hz=ramp, s21_real=ramp, s21_imag=-ramp)
    assert len(trace.s21_imag) == points


def test_a_height_that_was_not_measured_is_taken():
    assert math.isnan(make_trace(antennae_height_m=NAN).antennae_height_m)
