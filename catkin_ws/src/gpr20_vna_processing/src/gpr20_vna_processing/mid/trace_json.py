"""A trace as the text of its JSON file."""

from __future__ import annotations

import json
import math
from typing import Any, Dict

from gpr20_vna_processing.mid import utc_time
from gpr20_vna_processing.mid.trace_record import TraceRecord


def encode(trace: TraceRecord) -> bytes:
    """Return the content of a trace's file.

    Numbers are written with as many digits as bring the same float64 back; equal traces
    give equal bytes.
    """
    height = trace.antennae_height_m
    values: Dict[str, Any] = {
        "format": trace.format,
        "survey_id": trace.survey_id,
        "sample_id": trace.sample_id,
        "index": trace.index,
        "timestamp": utc_time.iso_text(trace.timestamp_us),
        "x_coord_mm": trace.x_coord_mm,
        "y_coord_mm": trace.y_coord_mm,
        "z_coord_deg": trace.z_coord_deg,
        "antennae_height_m": None if math.isnan(height) else height,
        "frequency_hz": trace.frequency_hz.tolist(),
        "s21_real": trace.s21_real.tolist(),
        "s21_imag": trace.s21_imag.tolist(),
        "sweep_started": utc_time.iso_text(trace.sweep_started_us),
        "sweep_ended": utc_time.iso_text(trace.sweep_ended_us),
        "quality": list(trace.quality),
    }
    return (json.dumps(values, allow_nan=False) + "\n").encode("ascii")
