"""Many traces at once, as arrays: what pictures of a survey need of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Sequence

import numpy as np

from gpr20_survey.trace.trace import Trace

SAMPLE = np.dtype("<c8")
POSITION = ("x_coord_mm", "y_coord_mm", "z_coord_deg")


@dataclass(frozen=True, eq=False)
class TraceBlock:
    """Traces of one survey that have the same frequencies.

    Attributes:
        survey_id: UUID of the survey.
        frequency_hz: Frequencies [Hz, float64, shape (points,)], ascending; empty without traces.
        indices: Places in the plan [int64, shape (traces,)].
        positions: Each row x [mm], y [mm], z [deg] [float64, shape (traces, 3)].
        heights_m: Above the ground [m, float64, shape (traces,)]; NaN if not measured.
        s21: S21, linear [complex64, shape (traces, points)].
    """

    survey_id: str
    frequency_hz: np.ndarray
    indices: np.ndarray
    positions: np.ndarray
    heights_m: np.ndarray
    s21: np.ndarray

    @classmethod
    def of(cls, survey_id: str, traces: Sequence[Trace]) -> TraceBlock:
        """Return the block of traces that have the same frequencies."""
        frequency_hz = traces[0].frequency_hz if traces else np.zeros(0)
        s21 = np.empty((len(traces), len(frequency_hz)), SAMPLE)
        for row, trace in zip(s21, traces):
            row.real, row.imag = trace.s21_real, trace.s21_imag
        places = [[getattr(one, name) for name in POSITION] for one in traces]
        return cls(
            survey_id,
            frequency_hz,
            np.array([one.index for one in traces], np.int64),
            np.array(places, np.float64).reshape(-1, 3),
            np.array([one.antennae_height_m for one in traces], np.float64),
            s21,
        )


def block_fields(block: TraceBlock) -> Dict[str, Any]:
    return {
        "survey_id": block.survey_id,
        "frequency_hz": block.frequency_hz.tolist(),
        "indices": block.indices.tolist(),
        **dict(zip(POSITION, block.positions.T.tolist())),
        "antennae_height_m": block.heights_m.tolist(),
        "s21": block.s21.tobytes(),
    }


def block_from(message: Any) -> TraceBlock:
    """Return the block of an answer of `read_traces`."""
    count, points = len(message.indices), len(message.frequency_hz)
    positions = [getattr(message, name) for name in POSITION]
    return TraceBlock(
        message.survey_id,
        np.array(message.frequency_hz, np.float64),
        np.array(message.indices, np.int64),
        np.array(positions, np.float64).T,
        np.array(message.antennae_height_m, np.float64),
        np.frombuffer(message.s21, SAMPLE).reshape(count, points),
    )
