"""Good traces, and how to compare them with what was stored, for tests."""

from __future__ import annotations

import json
import math
from dataclasses import astuple
from pathlib import Path
from typing import Any, Dict

import numpy as np

from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

SURVEY = "0f8fad5b-d9cb-469f-a165-70867728950e"
STARTED_US = 1_790_000_000_123_456
MESSAGES = Path(__file__).resolve().parents[3] / "gpr20_msgs" / "msg"
TRACE_DEFINITION = (MESSAGES / "Trace.msg").read_text()
# Of recordings that earlier versions made.
FORMER_DEFINITION = TRACE_DEFINITION[: TRACE_DEFINITION.index("# Settings of the VNA")]


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
    assert tuple(get("quality")) == trace.quality
    names = ("if_bandwidth_hz", "averages", "output_power")
    if trace.analyzer.is_known:
        assert tuple(map(get, names)) == astuple(trace.analyzer)
    elif isinstance(values, dict):
        assert not values.keys() & set(names)
    else:
        assert tuple(getattr(values, name, None) or None for name in names) == (None,) * 3


def read_json(path: Path) -> Dict[str, Any]:
    """Read strict JSON."""

    def refuse(name: str) -> None:
        raise ValueError(f"{name} is not JSON")

    return json.loads(path.read_text("ascii"), parse_constant=refuse)
