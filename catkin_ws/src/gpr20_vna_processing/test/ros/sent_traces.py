"""Traces that a test of the storage sends, and their numbers as they are found again."""

from __future__ import annotations

import math
import time
from types import MappingProxyType

import rospy

from gpr20_msgs.msg import Trace

# One moment for all: a trace that is sent again must be the very same.
MEASURED_S = math.floor(time.time()) - 1


def make_trace(survey_id: str, index: int, changes=MappingProxyType({})) -> Trace:
    now = rospy.Time(MEASURED_S)
    later = rospy.Time(now.secs, 123_456_789)  # nanoseconds are cut off everywhere
    trace = Trace(
        format="gpr20-trace/1",
        survey_id=survey_id,
        sample_id=f"{survey_id}-{index:06d}",
        index=index,
        timestamp=later,
        x_coord_mm=50.0 * index,
        y_coord_mm=50.0,
        z_coord_deg=90.0 * (index % 2),
        antennae_height_m=math.nan if index == 0 else 0.1 * index,
        frequency_hz=[600e6 + 512.0 * k for k in range(201)],
        s21_real=[math.sin(k + index) * 1e-3 for k in range(201)],
        s21_imag=[math.cos(k + index) * 1e-300 for k in range(201)],
        sweep_started=now,
        sweep_ended=later,
        quality=["level low"] if index == 2 else [],
    )
    for name, value in changes.items():
        setattr(trace, name, value)
    return trace


def numbers(trace) -> tuple:
    """Return what must be the same in JSON, bag, MCAP and topic."""
    get = trace.get if isinstance(trace, dict) else lambda name: getattr(trace, name)
    height = get("antennae_height_m")
    return (
        *(get(name) for name in ("index", "sample_id", "x_coord_mm", "y_coord_mm", "z_coord_deg")),
        None if height is None or math.isnan(height) else height,
        *(tuple(get(name)) for name in ("frequency_hz", "s21_real", "s21_imag", "quality")),
    )
