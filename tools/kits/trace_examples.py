"""Good traces, a survey with a whole plan, and how to compare them with what was stored."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, astuple
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict

import numpy as np

from gpr20_survey import axes
from gpr20_survey.axes import ZeroEpoch
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel
from gpr20_survey.plan.survey_points import survey_points
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import AuxValue, Trace

SURVEY = "0f8fad5b-d9cb-469f-a165-70867728950e"
STARTED_US = 1_790_000_000_123_456
MESSAGES = Path(__file__).resolve().parents[2] / "catkin_ws/src/gpr20_msgs/msg"
AUX = ("name", "value", "unit", "stamp")


def make_trace(index: int = 0, **changes: Any) -> Trace:
    """Return a good trace with some fields changed."""
    points = 5
    noise = np.random.default_rng(abs(index))
    fields: Dict[str, Any] = {
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
        "zeros": tuple(ZeroEpoch(3 + axis, STARTED_US - axis) for axis in range(axes.AXES)),
    }
    return Trace(**{**fields, **changes})


def assert_same_numbers(trace: Trace, values: Any) -> None:
    """Compare a trace with a message or the values of a JSON file, bit for bit."""
    is_json = isinstance(values, dict)
    get: Callable[[str], Any] = values.get if is_json else partial(getattr, values)
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
    found = tuple(map(get, ("if_bandwidth_hz", "averages", "output_power")))
    assert found == tuple((one or None) if is_json else one for one in astuple(trace.analyzer))
    assert tuple(map(_aux_of, get("aux"))) == trace.aux
    zeros = get("zero_epochs"), get("zero_times")
    if trace.zeros:
        assert tuple(ZeroEpoch(int(n), _time_us(time)) for n, time in zip(*zeros)) == trace.zeros
    else:
        assert zeros == (None, None) if is_json else not any(map(_time_us, zeros[1]))


def _aux_of(one: Any) -> AuxValue:
    values = one if isinstance(one, dict) else {name: getattr(one, name) for name in AUX}
    return AuxValue(values["name"], values["value"], values["unit"], _time_us(values["stamp"]))


def _time_us(stamp: Any) -> int:
    """Return the moment of a text, or of a ROS time of either library [us since 1970]."""
    if isinstance(stamp, str):
        return utc_time.parse_iso(stamp)
    names = ("sec", "nanosec") if hasattr(stamp, "nanosec") else ("secs", "nsecs")
    seconds, rest_ns = (int(getattr(stamp, name)) for name in names)
    return seconds % (1 << 32) * utc_time.US_PER_S + rest_ns // utc_time.NS_PER_US


def read_json(path: Path) -> Dict[str, Any]:
    """Read strict JSON."""

    def refuse(name: str) -> None:
        raise ValueError(f"{name} is not JSON")

    return json.loads(path.read_text("ascii"), parse_constant=refuse)


TRAVEL = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))
PARAMETERS = SurveyParameters(
    "127.0.0.1", 6e8, 6e9, 5, x_start_mm=10.0, x_stop_mm=20.0, x_points=3,
    y_start_mm=10.0, y_stop_mm=20.0, y_points=3, polarizations_deg=(0.0,),
)  # fmt: skip
POINTS = survey_points(PARAMETERS, TRAVEL)
AXES = {
    name: {"min_coord": one.lower, "max_coord": one.upper, "step_size": one.step}
    for name, one in zip("xyz", (TRAVEL.x, TRAVEL.y, TRAVEL.z))
}
METADATA = json.dumps(
    {
        "planned_traces": len(POINTS),
        "simulated": True,
        "parameters": asdict(PARAMETERS),
        "axes": AXES,
    }
)


def planned_trace(index: int, survey_id: str = SURVEY, **changes: Any) -> Trace:
    """Return the trace of a planned point, with some fields changed."""
    point = POINTS[index]
    fields = {
        "survey_id": survey_id,
        "timestamp_us": STARTED_US + 10**6 * (index + 2),
        "x_coord_mm": point.x_mm,
        "y_coord_mm": point.y_mm,
        "z_coord_deg": point.z_deg,
    }
    return make_trace(index, **{**fields, **changes})
