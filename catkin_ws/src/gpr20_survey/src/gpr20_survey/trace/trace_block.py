"""Many traces at once, as arrays: what pictures of a survey need of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace.trace import Trace

SAMPLE = np.dtype("<c8")
"""S21 in single precision, real part first, as it is sent."""


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
        places = [(one.x_coord_mm, one.y_coord_mm, one.z_coord_deg) for one in traces]
        return cls(
            survey_id,
            frequency_hz,
            np.array([one.index for one in traces], np.int64),
            np.array(places, np.float64).reshape(-1, 3),
            np.array([one.antennae_height_m for one in traces], np.float64),
            s21,
        )

    @classmethod
    def received(
        cls,
        survey_id: str,
        frequency_hz: Sequence[float],
        indices: Sequence[int],
        positions: Sequence[Sequence[float]],
        heights_m: Sequence[float],
        s21: bytes,
    ) -> TraceBlock:
        """Return a block that was sent, its arrays checked against each other.

        Args:
            survey_id: UUID of the survey.
            frequency_hz: Frequencies [Hz].
            indices: Places in the plan.
            positions: The x [mm], the y [mm] and the z [deg] of all traces.
            heights_m: Above the ground [m].
            s21: Samples of all traces, one trace after the other, of type `SAMPLE`.

        Raises:
            TraceRefusedError: Their lengths contradict each other, or a trace is there twice.
        """
        count, points = len(indices), len(frequency_hz)
        lengths = {count, len(set(indices)), len(heights_m), *map(len, positions)}
        if len(lengths) > 1 or len(s21) != count * points * SAMPLE.itemsize:
            raise TraceRefusedError(
                Message("the traces that were received are incomplete"), fault=faults.TRACE_DAMAGED
            )
        return cls(
            survey_id,
            np.array(frequency_hz, np.float64),
            np.array(indices, np.int64),
            np.array(positions, np.float64).T,
            np.array(heights_m, np.float64),
            np.frombuffer(s21, SAMPLE).reshape(count, points),
        )
