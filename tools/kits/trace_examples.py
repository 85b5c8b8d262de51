"""Good traces, and how to compare them with what was stored, for tests."""

from __future__ import annotations

import json
import math
from dataclasses import astuple
from pathlib import Path
from typing import Any, Callable, Dict, Tuple

import numpy as np

from gpr20_survey.axes.zero_epoch import AXES, ZeroEpoch, Zeros
from gpr20_survey.trace import trace_message, utc_time
from gpr20_survey.trace.aux_value import AuxValue
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

SURVEY = "0f8fad5b-d9cb-469f-a165-70867728950e"
STARTED_US = 1_790_000_000_123_456
MESSAGES = Path(__file__).resolve().parents[2] / "catkin_ws/src/gpr20_msgs/msg"
TRACE_TEXT = (MESSAGES / "Trace.msg").read_text()


def _definition(text: str) -> str:
    """Return a definition with the types that it contains, as a recording holds it."""
    return "\n".join(
        (
            *(text, "=" * 80, "MSG: std_msgs/Header"),
            *("uint32 seq\ntime stamp\nstring frame_id\n", "=" * 80, "MSG: gpr20_msgs/AuxValue"),
            (MESSAGES / "AuxValue.msg").read_text(),
        )
    )


TRACE_DEFINITION = _definition(TRACE_TEXT)
# Of recordings that earlier versions made, by checksum.
_WITHOUT_ZEROS = TRACE_TEXT[: TRACE_TEXT.index("# Zeros that")]
_WITHOUT_HEADER = "".join(
    line
    for line in _WITHOUT_ZEROS.splitlines(keepends=True)
    if not line.startswith(("std_msgs/Header", "AuxValue"))
)
FORMER_DEFINITIONS = {
    trace_message.WITHOUT_ZEROS_MD5SUM: _definition(_WITHOUT_ZEROS),
    trace_message.WITHOUT_HEADER_MD5SUM: _WITHOUT_HEADER,
    trace_message.WITHOUT_SETTINGS_MD5SUM: _WITHOUT_HEADER[
        : _WITHOUT_HEADER.index("# Settings of the VNA")
    ],
}


def make_trace(index: int = 0, **changes: Any) -> Trace:
    """Return a good trace with some fields changed."""
    points = 5
    noise = np.random.default_rng(abs(index))
    fields: Dict[str, Any] = {
        "format": "gpr20-trace/1",
        "survey_id": SURVEY,
        "sample_id": f"sample-{index}",
        "index": index,
        "timestamp_us": STARTED_US + 1_000_003,
        "x_coord_mm": 50.0,
        "y_coord_mm": 12.345,
        "z_coord_deg": 90.0,
        "antennae_height_m": 0.1 + 0.2,
        "frequency_hz": np.linspace(6e8, 6e9, points),
        "s21_real": noise.standard_normal(points),
        "s21_imag": noise.standard_normal(points),
        "sweep_started_us": STARTED_US + 1,
        "sweep_ended_us": STARTED_US + 1_000_001,
        "quality": ("level low",),
        "analyzer": AnalyzerSettings(1000.0, 4, "HIGH"),
        "aux": (AuxValue("soil_temperature", 18.5, "\N{DEGREE SIGN}C", STARTED_US),),
        "zeros": tuple(ZeroEpoch(3 + axis, STARTED_US - axis) for axis in range(AXES)),
    }
    return Trace(**{**fields, **changes})


def assert_same_numbers(trace: Trace, values: Any) -> None:
    """Compare a trace with a message or the values of a JSON file, bit for bit."""
    get = values.get if isinstance(values, dict) else lambda name: getattr(values, name)
    for name in ("frequency_hz", "s21_real", "s21_imag"):
        assert np.array(get(name), np.float64).tobytes() == getattr(trace, name).tobytes()
    for name in ("x_coord_mm", "y_coord_mm", "z_coord_deg", "index", "sample_id", "survey_id"):
        assert get(name) == getattr(trace, name)
    height = get("antennae_height_m")
    if math.isnan(trace.antennae_height_m):
        assert height is None or math.isnan(height)
    else:
        assert height == trace.antennae_height_m
    assert tuple(get("quality") or ()) == trace.quality
    names = ("if_bandwidth_hz", "averages", "output_power")
    if trace.analyzer.is_known:
        assert tuple(map(get, names)) == astuple(trace.analyzer)
    elif isinstance(values, dict):
        assert not values.keys() & set(names)
    else:
        assert tuple(getattr(values, name, None) or None for name in names) == (None,) * 3
    assert _aux_of(get("aux") if isinstance(values, dict) else getattr(values, "aux", None)) == (
        trace.aux
    )
    assert _zeros_of(get) == trace.zeros


def _aux_of(values: Any) -> Tuple[AuxValue, ...]:
    """Return the values of a JSON file or a message; None is of a former version."""
    return tuple(
        AuxValue(one["name"], one["value"], one["unit"], utc_time.parse_iso(one["stamp"]))
        if isinstance(one, dict)
        else AuxValue(one.name, one.value, one.unit, _time_us(one.stamp))
        for one in values or ()
    )


def _zeros_of(get: Callable[[str], Any]) -> Zeros:
    """Return the zeros of a JSON file or a message; a former version has none."""
    try:
        numbers, times = get("zero_epochs"), get("zero_times")
    except AttributeError:
        return ()
    zeros = tuple(
        ZeroEpoch(
            int(number), utc_time.parse_iso(time) if isinstance(time, str) else _time_us(time)
        )
        for number, time in zip(() if numbers is None else numbers, times or ())
    )
    return zeros if any(one.is_known for one in zeros) else ()


def _time_us(stamp: Any) -> int:
    """Return the moment of a ROS time of either library [us since 1970]."""
    names = ("sec", "nanosec") if hasattr(stamp, "nanosec") else ("secs", "nsecs")
    seconds, rest_ns = (int(getattr(stamp, name)) for name in names)
    return seconds % (1 << 32) * utc_time.US_PER_S + rest_ns // utc_time.NS_PER_US


def read_json(path: Path) -> Dict[str, Any]:
    """Read strict JSON."""

    def refuse(name: str) -> None:
        raise ValueError(f"{name} is not JSON")

    return json.loads(path.read_text("ascii"), parse_constant=refuse)
