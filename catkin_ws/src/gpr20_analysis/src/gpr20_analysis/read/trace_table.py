"""The traces of a survey, collected."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Set, Tuple

import numpy as np

from gpr20_analysis.read.sources import Fault, Position
from gpr20_analysis.read.survey_grid import Plan, planned_grid
from gpr20_survey.trace.trace import Trace

EMPTY = complex(math.nan, math.nan)
Allocate = Callable[[Tuple[int, int]], np.ndarray]
"""Makes an array of complex128 of a shape (samples, frequencies), filled with NaN."""


def in_memory(shape: Tuple[int, int]) -> np.ndarray:
    """Return an array of NaN."""
    return np.full(shape, EMPTY, np.complex128)


@dataclass
class Sample:
    """A trace without its numbers, and the row that has them."""

    row: int
    index: int
    sample_id: str
    position: Position
    height_m: float
    times_us: Tuple[int, int, int]
    remarks: Tuple[str, ...]

    @classmethod
    def of(cls, trace: Trace, row: int) -> Sample:
        """Return the facts of a trace whose numbers are in a row."""
        return cls(
            row,
            trace.index,
            trace.sample_id,
            _position(trace),
            trace.antennae_height_m,
            (trace.timestamp_us, trace.sweep_started_us, trace.sweep_ended_us),
            tuple(trace.quality),
        )


class TraceTable:
    """Collects traces that can be in one Dataset; what cannot becomes a fault."""

    def __init__(self, count: int, plan: Optional[Plan], allocate: Allocate) -> None:
        self.faults: List[Fault] = []
        self.samples: Dict[int, Sample] = {}
        """What was taken, by index."""
        self.void: Set[int] = set()
        """Indices of what was contradicted later."""
        self.frequency_hz: Optional[np.ndarray] = None
        self.survey_id: Optional[str] = None
        self.other_frequencies = 0
        self.rows = np.empty((0, 0), np.complex128)
        """The numbers: in the order of the grid with a plan, else of reading."""
        # With a plan the numbers are put where they belong at once, so they are there only once.
        self._cells = planned_grid(plan).places(plan.positions) if plan else None
        self._capacity = max(count, 1) if plan is None else planned_grid(plan).cells
        self._allocate = allocate
        self._contents: Dict[int, int] = {}
        self._repeated = 0
        self._alike = 0

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
        elif trace.index in self.samples:
            self._repeat(trace, self.samples[trace.index])
        else:
            self._take(trace)

    def notes(self) -> List[str]:
        """Return what only the whole survey tells."""
        found = []
        if self._repeated:
            found.append(f"{self._repeated} traces are stored more than once, all the same")
        if self._alike:
            found.append(
                f"{self._alike} samples have exactly the numbers of another one: nothing that is "
                "measured does; look whether the instrument answered twice with one sweep"
            )
        return found

    def _take(self, trace: Trace) -> None:
        row = len(self.samples) if self._cells is None else int(self._cells[trace.index])
        if row >= len(self.rows):
            grown = self._allocate((2 * row, self.rows.shape[1]))
            grown[:row] = self.rows
            self.rows = grown
        values = self.rows[row]
        values.real, values.imag = trace.s21_real, trace.s21_imag
        content = hash(values.tobytes())
        self._alike += self._contents.setdefault(content, trace.index) != trace.index
        self.samples[trace.index] = Sample.of(trace, row)

    def _repeat(self, trace: Trace, taken: Sample) -> None:
        values = self.rows[taken.row]
        # By their texts: NaN stands for a height that was not measured, and differs from itself.
        if (
            repr(Sample.of(trace, taken.row)) == repr(taken)
            and np.array_equal(values.real, trace.s21_real)
            and np.array_equal(values.imag, trace.s21_imag)
        ):
            self._repeated += 1
            return
        self.void.add(trace.index)
        self._refuse(trace, "is stored twice with different content; none of both is used")

    def _refuse(self, trace: Trace, reason: str) -> None:
        self.faults.append(Fault(f"{trace.label} {reason}", trace.index, _position(trace)))


def _position(trace: Trace) -> Position:
    return trace.z_coord_deg, trace.y_coord_mm, trace.x_coord_mm


def _span(frequency_hz: np.ndarray) -> str:
    return f"{len(frequency_hz)} from {frequency_hz[0]:g} to {frequency_hz[-1]:g} Hz"
