"""Traces that a test of the storage sends, and their numbers as they are found again."""

from __future__ import annotations

import math
import time
from types import MappingProxyType

import rospy
from std_msgs.msg import Header

from gpr20_msgs.msg import AuxValue, Trace
from gpr20_survey.frames import ANTENNA_LINK

# One moment for all: a trace that is sent again must be the very same.
MEASURED_S = math.floor(time.time()) - 1


def make_trace(survey_id: str, index: int, changes=MappingProxyType({})) -> Trace:
    now = rospy.Time(MEASURED_S)
    later = rospy.Time(now.secs, 123_456_789)  # nanoseconds are cut off everywhere
    trace = Trace(
        header=Header(seq=index, frame_id=ANTENNA_LINK),
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
        aux=[AuxValue("soil_moisture", 0.1 * index, "m3/m3", later)] if index % 2 else [],
    )
    for name, value in changes.items():
        setattr(trace, name, value)
    trace.header.stamp = trace.timestamp
    return trace


def numbers(trace) -> tuple:
    """Return what must be the same in JSON, bag, MCAP and topic."""
    get = trace.get if isinstance(trace, dict) else lambda name: getattr(trace, name)
    height = get("antennae_height_m")
    return (
        *(get(name) for name in ("index", "sample_id", "x_coord_mm", "y_coord_mm", "z_coord_deg")),
        None if height is None or math.isnan(height) else height,
        *(tuple(get(name)) for name in ("frequency_hz", "s21_real", "s21_imag", "quality")),
        tuple(
            (one["name"], one["value"]) if isinstance(one, dict) else (one.name, one.value)
            for one in (trace.get("aux", ()) if isinstance(trace, dict) else trace.aux)
        ),
    )
