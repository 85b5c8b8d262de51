"""What is measured of a plan, from the run-length coded `survey_coverage`."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Dict, Iterable, Mapping, Optional, Tuple

import numpy as np

from gpr20_common.faults import VERSIONS_DIFFER
from gpr20_common.message import Message
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.grid import Place, Stop, SurveyGrid
from gpr20_survey.plan.survey_parameters import MAX_TRACES
from gpr20_survey.plan.survey_state import SampleState


class StopState(enum.IntEnum):
    """State of a stop: that of all its polarizations together."""

    MISSING = 0
    PARTLY = 1
    DONE = 2
    FAILED = 3


class Cell(enum.IntEnum):
    """What a cell of the ground is: each has a pattern, and is known without its colours."""

    MISSING = StopState.MISSING
    PARTLY = StopState.PARTLY
    DONE = StopState.DONE
    FAILED = StopState.FAILED
    LOADING = 4
    """Stored, but not here yet."""
    HIDING = 5
    """A mine could hide here."""
    HIDING_SHALLOW = 6
    """A mine could hide here even if it is not deep."""
    BLANK = 7
    """Nothing is painted."""


@dataclass(frozen=True)
class CoverageRuns:
    """One message of `survey_coverage`.

    Args:
        survey_id: UUID.
        planned: Number of planned traces.
        starts: Place in the plan at which each run begins, ascending from 0.
        states: State of the traces of each run.
        failures: Why traces failed, by their place in the plan.
    """

    survey_id: str
    planned: int
    starts: Tuple[int, ...]
    states: Tuple[int, ...]
    failures: Mapping[int, Message] = field(default_factory=dict)

    def trace_states(self) -> np.ndarray:
        """Return the state of every planned trace (uint8, shape `planned`).

        Raises:
            SurveyNotReadableError: The runs contradict each other.
        """
        bounds = np.array([*self.starts, self.planned], np.int64)
        known = {int(state) for state in SampleState}
        if (
            not self.planned <= MAX_TRACES
            or len(self.starts) != len(self.states)
            or bounds[0] != 0
            or (np.diff(bounds) <= 0).any()
            or not known.issuperset(self.states)
        ):
            raise SurveyNotReadableError(
                Message(
                    "the coverage of survey {survey} is not a sequence of runs from 0 to {planned}",
                    survey=self.survey_id[:40],
                    planned=self.planned,
                ),
                fault=VERSIONS_DIFFER,
            )
        return np.repeat(np.array(self.states, np.uint8), np.diff(bounds))


def coverage_of_stored(survey_id: str, planned: int, stored: Iterable[int]) -> CoverageRuns:
    """Return the coverage of a past survey, of which only the stored traces are known."""
    states = np.zeros(planned, np.uint8)
    indices = np.fromiter(stored, np.int64)
    states[indices[(indices >= 0) & (indices < planned)]] = SampleState.MEASURED
    starts = np.flatnonzero(np.diff(states, prepend=255))
    return CoverageRuns(survey_id, planned, tuple(starts.tolist()), tuple(states[starts].tolist()))


def stop_states(grid: SurveyGrid, trace_states: np.ndarray) -> np.ndarray:
    """Return the StopState of every stop (uint8, shape rows x columns).

    A stop is done only when each of its polarizations is stored.
    """
    traces = np.zeros((*grid.shape, len(grid.rotations_deg)), np.uint8)
    traces[grid.cells(np.arange(grid.planned))] = trace_states
    stored, failed = traces == SampleState.MEASURED, traces == SampleState.FAILED
    states = np.full(grid.shape, StopState.MISSING, np.uint8)
    states[stored.any(axis=2)] = StopState.PARTLY
    states[stored.all(axis=2)] = StopState.DONE
    states[failed.any(axis=2)] = StopState.FAILED
    return states


class MapModel:
    """Joins the plan of a survey and its coverage, whichever comes first.

    Attributes:
        revision: Changes with plan and coverage.
        grid: The plan; None before it is known.
        trace_states: State of every planned trace; None while it is not known.
        stop_states: StopState of every stop (rows x columns); None while it is not known.
        current: The stop that is being visited.
    """

    def __init__(self) -> None:
        self._coverage: Optional[Tuple[CoverageRuns, np.ndarray]] = None
        self.revision = 0
        self.set_grid(None)

    def set_grid(self, grid: Optional[SurveyGrid]) -> None:
        """Take another plan."""
        self.grid = grid
        self.current: Optional[Stop] = None
        self._combine()

    def set_coverage(self, coverage: CoverageRuns) -> None:
        """Take what has been measured.

        Raises:
            SurveyNotReadableError: It contradicts itself or the plan.
        """
        self._coverage = coverage, coverage.trace_states()
        self._combine()

    def set_target(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas move to (X, Y); None: nowhere."""
        self.current = None
        if self.grid is not None and place_mm is not None:
            self.current = self.grid.nearest_stop(*place_mm)

    @property
    def stored(self) -> np.ndarray:
        """The places in the plan whose traces are durably stored, ascending."""
        states = self.trace_states
        return np.flatnonzero(np.zeros(0) if states is None else states == SampleState.MEASURED)

    def counts(self) -> Optional[Dict[StopState, int]]:
        """Return how many stops are in which state; None while that is not known."""
        if self.stop_states is None:
            return None
        return {one: int(np.count_nonzero(self.stop_states == one)) for one in StopState}

    def reasons_at(self, stop: Stop) -> Tuple[Message, ...]:
        """Return why traces of a stop failed."""
        grid, reasons = self.grid, self._reasons
        if grid is None:
            return ()
        indices = [grid.index(stop, one) for one in range(len(grid.rotations_deg))]
        return tuple(reasons[one] for one in indices if one in reasons)

    def cells(self, loading: Optional[np.ndarray]) -> Optional[np.ndarray]:
        """Return the Cell of each stop (uint8, both axes ascending); None: not known.

        Args:
            loading: Which stops are stored but not here yet (bool, rows x columns); None: none.
        """
        grid, states = self.grid, self.stop_states
        if grid is None or states is None:
            return None
        cells = states if loading is None else np.where(loading, Cell.LOADING, states)
        return cells[grid.ascending].astype(np.uint8)

    def failed(self, most: int) -> Tuple[Place, ...]:
        """Return where stops have failed."""
        grid, states = self.grid, self.stop_states
        if grid is None or states is None:
            return ()
        found = np.argwhere(states == StopState.FAILED)[:most].tolist()
        return tuple(grid.place_of(Stop(*one)) for one in found)

    def next_problem(self, after: Optional[Stop]) -> Optional[Stop]:
        """Return the next unfinished stop, row by row; None if all are done."""
        if self.stop_states is None:
            return None
        problems = np.flatnonzero(self.stop_states != StopState.DONE)
        columns = self.stop_states.shape[1]
        last = -1 if after is None else after.row * columns + after.column
        found = [*problems[problems > last][:1].tolist(), *problems[:1].tolist()]
        return Stop(*divmod(found[0], columns)) if found else None

    def _combine(self) -> None:
        """Work out the states, once plan and coverage are those of the same survey."""
        self.revision += 1
        self.trace_states: Optional[np.ndarray] = None
        self.stop_states: Optional[np.ndarray] = None
        self._reasons: Mapping[int, Message] = {}
        if self.grid is None or self._coverage is None:
            return
        coverage, traces = self._coverage
        if coverage.survey_id != self.grid.survey_id:
            return
        if coverage.planned != self.grid.planned:
            self._coverage = None
            raise SurveyNotReadableError(
                Message(
                    "the coverage has {found} traces; the plan of the survey has {planned}",
                    found=coverage.planned,
                    planned=self.grid.planned,
                ),
                fault=VERSIONS_DIFFER,
            )
        self.trace_states, self.stop_states = traces, stop_states(self.grid, traces)
        self._reasons = coverage.failures
