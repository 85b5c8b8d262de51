"""What the map shows: the planned stops, the state of each, and where the antennas are."""

from __future__ import annotations

from typing import Dict, Mapping, Optional, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_operator import faults
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.coverage import CoverageRuns, StopState, stop_states
from gpr20_operator.ground.grid import Cell, Stop, SurveyGrid


class MapModel:
    """Joins the plan of a survey and its coverage, whichever comes first.

    Attributes:
        grid: The plan; None before it is known.
        current: The stop that is being visited.
    """

    def __init__(self) -> None:
        self.grid: Optional[SurveyGrid] = None
        self._coverage: Optional[CoverageRuns] = None
        self._traces = np.zeros(0, np.uint8)
        self._stops = np.zeros((0, 0), np.uint8)
        self._reasons: Mapping[int, Message] = {}
        self.current: Optional[Stop] = None
        self.revision = 0

    @property
    def trace_states(self) -> Optional[np.ndarray]:
        """State of every planned trace; None while it is not known."""
        return self._traces if self._covers() else None

    @property
    def stop_states(self) -> Optional[np.ndarray]:
        """StopState of every stop (rows x columns); None while it is not known."""
        return self._stops if self._covers() else None

    @property
    def verdict(self) -> Optional[Message]:
        """The coverage in one sentence; None if there is none."""
        return self._coverage.verdict if self._coverage and self._covers() else None

    def set_grid(self, grid: Optional[SurveyGrid]) -> None:
        """Take another plan."""
        self.grid = grid
        self.current = None
        self._combine()

    def set_coverage(self, coverage: CoverageRuns) -> None:
        """Take what has been measured.

        Raises:
            SurveyNotReadableError: It contradicts itself or the plan.
        """
        traces = coverage.trace_states()
        self._coverage, self._traces = coverage, traces
        self._reasons = coverage.failures
        self._combine()

    def set_target(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas move to (X, Y); None: nowhere."""
        self.current = None
        if self.grid is not None and place_mm is not None:
            self.current = self.grid.nearest_stop(*place_mm)

    def counts(self) -> Optional[Dict[StopState, int]]:
        """Return how many stops are in which state; None while that is not known."""
        if not self._covers():
            return None
        numbers = np.bincount(self._stops.ravel(), minlength=len(StopState))
        return {state: int(numbers[state]) for state in StopState}

    def state_at(self, stop: Stop) -> Optional[StopState]:
        """Return the state of a stop; None while it is not known."""
        return StopState(int(self._stops[stop.row, stop.column])) if self._covers() else None

    def reasons_at(self, stop: Stop) -> Tuple[Message, ...]:
        """Return why traces of a stop failed."""
        if self.grid is None:
            return ()
        count = len(self.grid.rotations_deg)
        indices = [self.grid.index(Cell(stop, number)) for number in range(count)]
        return tuple(self._reasons[index] for index in indices if index in self._reasons)

    def next_problem(self, after: Optional[Stop]) -> Optional[Stop]:
        """Return the next unfinished stop, row by row; None if all are done."""
        if not self._covers():
            return None
        problems = np.flatnonzero(self._stops.ravel() != StopState.DONE)
        if not problems.size:
            return None
        columns = self._stops.shape[1]
        place = -1 if after is None else after.row * columns + after.column
        later = problems[problems > place]
        row, column = divmod(int(later[0] if later.size else problems[0]), columns)
        return Stop(row, column)

    def _covers(self) -> bool:
        return (
            self.grid is not None
            and self._coverage is not None
            and self._coverage.survey_id == self.grid.survey_id
        )

    def _combine(self) -> None:
        self.revision += 1
        if self.grid is None or not self._covers():
            return
        if len(self._traces) != self.grid.planned:
            planned = len(self._traces)
            self._coverage = None
            raise SurveyNotReadableError(
                Message(
                    "the coverage has {found} traces; the plan of the survey has {planned}",
                    found=planned,
                    planned=self.grid.planned,
                ),
                fault=faults.COVERAGE_WRONG,
            )
        self._stops = stop_states(self.grid, self._traces)
