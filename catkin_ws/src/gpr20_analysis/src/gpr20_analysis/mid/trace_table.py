"""The traces of a survey, collected in the order of their reading."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Set, Tuple

import numpy as np

from gpr20_analysis.mid.survey_source import Fault, Position
from gpr20_survey.trace.trace import Trace

Allocate = Callable[[Tuple[int, int]], np.ndarray]
"""Makes an array of complex128 of a shape (traces, frequencies), filled with NaN."""


def in_memory(shape: Tuple[int, int]) -> np.ndarray:
    """Return an array of NaN."""
    return np.full(shape, complex(math.nan, math.nan), np.complex128)


@dataclass
class SampleFacts:
    """A trace without its numbers; times in microseconds since 1970, UTC."""

    index: int
    sample_id: str
    position: Position
    height_m: float
    timestamp_us: int
    sweep_started_us: int
    sweep_ended_us: int
    remarks: Tuple[str, ...]


class TraceTable:
    """Collects traces that can stand in one Dataset; what cannot becomes a fault."""

    def __init__(self, capacity: int, allocate: Allocate = in_memory) -> None:
        """Make an empty table.

        Args:
            capacity: How many samples are expected.
            allocate: Makes the array of the numbers.
        """
        self.faults: List[Fault] = []
        self.notes: List[str] = []
        self.samples: List[SampleFacts] = []
        """What was taken, in the order of the rows."""
        self.frequency_hz: Optional[np.ndarray] = None
        self.survey_id: Optional[str] = None
        self.other_frequencies = 0
        self.rows: np.ndarray = np.empty((0, 0), np.complex128)
        """The numbers (at least as many as there are samples, frequency)."""
        self._capacity = max(capacity, 1)
        self._allocate = allocate
        self._places: Dict[int, int] = {}
        self._contents: Dict[int, int] = {}
        self._repeated = 0
        self._alike = 0
        self._void: Set[int] = set()

    def add(self, trace: Trace) -> None:
        """Take a trace, or name why it cannot be taken."""
        if self.frequency_hz is None:
            self.frequency_hz = trace.frequency_hz
            self.survey_id = trace.survey_id
            self.rows = self._allocate((self._capacity, len(trace.frequency_hz)))
        if trace.survey_id != self.survey_id:
            self.faults.append(Fault(f"{trace.label} belongs to survey {trace.survey_id}"))
        elif not np.array_equal(trace.frequency_hz, self.frequency_hz):
            self.other_frequencies += 1
            self._refuse(
                trace,
                f"has other frequencies ({_span(trace.frequency_hz)}) than the "
                f"first trace ({_span(self.frequency_hz)})",
            )
        elif trace.index in self._places:
            self._repeat(trace)
        else:
            self._take(trace)

    def finish(self) -> None:
        """Add the notes that only the whole survey tells."""
        if self._repeated:
            self.notes.append(f"{self._repeated} traces are stored more than once, all the same")
        if self._alike:
            self.notes.append(
                f"{self._alike} samples have exactly the numbers of another one: nothing that is "
                "measured does; look whether the instrument answered twice with one sweep"
            )

    def is_void(self, row: int) -> bool:
        """Say whether what was taken in a row was contradicted later."""
        return row in self._void

    def _take(self, trace: Trace) -> None:
        row = len(self.samples)
        if row == len(self.rows):
            grown = self._allocate((2 * row, self.rows.shape[1]))
            grown[:row] = self.rows
            self.rows = grown
        values = self.rows[row]
        values.real, values.imag = trace.s21_real, trace.s21_imag
        content = hash(values.tobytes())
        self._alike += self._contents.setdefault(content, trace.index) != trace.index
        self._places[trace.index] = row
        self.samples.append(_facts(trace))

    def _repeat(self, trace: Trace) -> None:
        row = self._places[trace.index]
        values = self.rows[row]
        # By their texts: NaN stands for a height that was not measured, and differs from itself.
        same = repr(_facts(trace)) == repr(self.samples[row])
        if (
            same
            and np.array_equal(values.real, trace.s21_real)
            and np.array_equal(values.imag, trace.s21_imag)
        ):
            self._repeated += 1
            return
        self._void.add(row)
        self._refuse(trace, "is stored twice with different content; none of both is used")

    def _refuse(self, trace: Trace, reason: str) -> None:
        self.faults.append(Fault(f"{trace.label} {reason}", trace.index, position_of(trace)))


def position_of(trace: Trace) -> Position:
    """Return the rotation [deg], y and x [mm] of a trace."""
    return trace.z_coord_deg, trace.y_coord_mm, trace.x_coord_mm


def _facts(trace: Trace) -> SampleFacts:
    return SampleFacts(
        trace.index,
        trace.sample_id,
        position_of(trace),
        trace.antennae_height_m,
        trace.timestamp_us,
        trace.sweep_started_us,
        trace.sweep_ended_us,
        tuple(trace.quality),
    )


def _span(frequency_hz: np.ndarray) -> str:
    return f"{len(frequency_hz)} from {frequency_hz[0]:g} to {frequency_hz[-1]:g} Hz"
