from __future__ import annotations

import math

import numpy as np
from case_kit import each_case
from fault_kit import raises_fault
from trace_examples import STARTED_US, make_trace

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

NAN, INF = math.nan, math.inf


def with_value(value: float) -> np.ndarray:
    return np.array([1.0, 2.0, value, 4.0, 5.0])


@each_case(
    "changes, expected",
    [
        ({"format": "gpr20-trace/2"}, ("trace.not_allowed", "gpr20-trace/2")),
        ({"survey_id": ""}, ("trace.not_allowed", "survey_id")),
        ({"survey_id": "0F8FAD5B-D9CB-469F-A165-70867728950E"}, ("trace.not_allowed", "survey_id")),
        ({"sample_id": ""}, ("trace.not_allowed", "sample_id")),
        ({"sample_id": "../../etc/passwd"}, ("trace.not_allowed", "sample_id")),
        ({"sample_id": "a/b"}, ("trace.not_allowed", "sample_id")),
        ({"sample_id": "a\n"}, ("trace.not_allowed", "sample_id")),
        ({"sample_id": "a" * 129}, ("trace.not_allowed", "sample_id")),
        ({"index": -1}, ("trace.not_allowed", "index", -1)),
        ({"index": 1_000_000}, ("trace.not_allowed", "index", 1000000)),
        ({"x_coord_mm": NAN}, ("trace.not_allowed", "x_coord_mm", "nan")),
        ({"y_coord_mm": INF}, ("trace.not_allowed", "y_coord_mm", "inf")),
        ({"z_coord_deg": -10_000.1}, ("trace.not_allowed", "z_coord_deg")),
        ({"antennae_height_m": -INF}, ("sensor.not_finite",)),
        ({"frequency_hz": with_value(2.0)}, ("vna.wrong_sweep",)),
        ({"frequency_hz": with_value(NAN)}, ("vna.wrong_sweep", "frequency_hz", 1)),
        ({"frequency_hz": np.array([0.0, 1, 2, 3, 4])}, ("vna.wrong_sweep",)),
        ({"frequency_hz": np.linspace(1, 2, 6)}, ("vna.wrong_sweep", "s21_real", 5, 6)),
        ({"s21_real": with_value(NAN)}, ("vna.wrong_sweep", "s21_real", 1)),
        ({"s21_imag": with_value(-INF)}, ("vna.wrong_sweep", "s21_imag", 1)),
        ({"s21_imag": np.ones(4)}, ("vna.wrong_sweep", "s21_imag", 4, 5)),
        ({"s21_imag": np.ones(5, np.float32)}, ("vna.wrong_sweep", "s21_imag")),
        ({"timestamp_us": 0}, ("clock.wrong", "timestamp", 1970)),
        ({"sweep_started_us": 0}, ("clock.wrong", "sweep_started", 1970)),
        ({"sweep_ended_us": 0}, ("clock.wrong", "sweep_ended", 1970)),
        ({"sweep_ended_us": STARTED_US}, ("clock.wrong",)),
        ({"quality": ("a\x00",)}, ("trace.not_allowed",)),
        ({"quality": ("\ud800",)}, ("trace.not_allowed",)),
        ({"quality": ("a" * 201,)}, ("trace.not_allowed", 200)),
        ({"quality": ("a",) * 33}, ("trace.not_allowed", 33)),
        ({"analyzer": AnalyzerSettings(NAN)}, ("vna.wrong_sweep", "if_bandwidth_hz", "nan")),
        ({"analyzer": AnalyzerSettings(INF)}, ("vna.wrong_sweep", "if_bandwidth_hz", "inf")),
        ({"analyzer": AnalyzerSettings(-1.0)}, ("vna.wrong_sweep", "if_bandwidth_hz", -1)),
        ({"analyzer": AnalyzerSettings(-0.0)}, ("vna.wrong_sweep", "if_bandwidth_hz", "-0")),
        ({"analyzer": AnalyzerSettings(2e9)}, ("vna.wrong_sweep", "if_bandwidth_hz", 2000000000)),
        ({"analyzer": AnalyzerSettings(averages=-1)}, ("vna.wrong_sweep", "averages", -1)),
        (
            {"analyzer": AnalyzerSettings(averages=1_000_001)},
            ("vna.wrong_sweep", "averages", 1000001),
        ),
        ({"analyzer": AnalyzerSettings(output_power="A\n")}, ("vna.wrong_sweep",)),
        ({"analyzer": AnalyzerSettings(output_power="A" * 33)}, ("vna.wrong_sweep",)),
    ],
)
def test_a_wrong_value_is_refused_by_name(changes, expected):
    with raises_fault(*expected, error=TraceRefusedError):
        make_trace(**changes)


@each_case("points", [0, 1, 4002])
def test_too_few_or_too_many_points_are_refused(points):
    ramp = np.arange(1.0, points + 1.0)
    with raises_fault("vna.wrong_sweep", points, error=TraceRefusedError):
        make_trace(frequency_hz=ramp, s21_real=ramp, s21_imag=ramp)


@each_case("points", [2, 4001])
def test_the_smallest_and_the_largest_sweep_are_taken(points):
    ramp = np.arange(1.0, points + 1.0)
    trace = make_trace(frequency_hz=ramp, s21_real=ramp, s21_imag=-ramp)
    assert len(trace.s21_imag) == points
