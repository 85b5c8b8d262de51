"""The states of the planned traces, from the run-length coded `survey_coverage`."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Iterable, Mapping, Optional, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_operator import faults
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.grid import SurveyGrid
from gpr20_survey.plan.coverage import SampleState
from gpr20_survey.plan.survey_parameters import MAX_TRACES


class StopState(enum.IntEnum):
    """State of a stop: that of all its polarizations together."""

    MISSING = 0
    PARTLY = 1
    DONE = 2
    FAILED = 3


@dataclass(frozen=True)
class CoverageRuns:
    """One message of `survey_coverage`.

    Args:
        survey_id: UUID.
        planned: Number of planned traces.
        starts: Place in the plan at which each run begins, ascending from 0.
        states: State of the traces of each run.
        failures: Why traces failed, by their place in the plan.
        verdict: One sentence; None if there is none.
    """

    survey_id: str
    planned: int
    starts: Tuple[int, ...]
    states: Tuple[int, ...]
    failures: Mapping[int, Message] = field(default_factory=dict)
    verdict: Optional[Message] = None

    def trace_states(self) -> np.ndarray:
        """Return the state of every planned trace (uint8, shape `planned`).

        Raises:
            SurveyNotReadableError: The runs contradict each other.
        """
        if not 0 <= self.planned <= MAX_TRACES:
            raise SurveyNotReadableError(
                Message(
                    "the coverage has {planned} traces; a survey has at most {limit}",
                    planned=self.planned,
                    limit=MAX_TRACES,
                ),
                fault=faults.COVERAGE_WRONG,
            )
        bounds = np.array([*self.starts, self.planned], np.int64)
        known = {int(state) for state in SampleState}
        if (
            len(self.starts) != len(self.states)
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
                fault=faults.COVERAGE_WRONG,
            )
        return np.repeat(np.array(self.states, np.uint8), np.diff(bounds))


def coverage_of_stored(survey_id: str, planned: int, stored: Iterable[int]) -> CoverageRuns:
    """Return the coverage of a past survey, of which only the stored traces are known."""
    states = np.zeros(planned, np.uint8)
    indices = np.fromiter(stored, np.int64)
    states[indices[indices < planned]] = SampleState.MEASURED
    starts = np.flatnonzero(np.diff(states, prepend=255))
    return CoverageRuns(survey_id, planned, tuple(starts.tolist()), tuple(states[starts].tolist()))


def is_stored(trace_states: np.ndarray) -> np.ndarray:
    """Return which traces are durably stored (bool, the same shape)."""
    return (trace_states == SampleState.MEASURED) | (trace_states == SampleState.REMEASURED)


def stop_states(grid: SurveyGrid, trace_states: np.ndarray) -> np.ndarray:
    """Return the StopState of every stop (uint8, shape rows x columns).

    A stop is done only when each of its polarizations is stored.
    """
    row, column, polarization = grid.cells(np.arange(grid.planned))
    stored = np.zeros((*grid.shape, len(grid.rotations_deg)), bool)
    failed = np.zeros_like(stored)
    stored[row, column, polarization] = is_stored(trace_states)
    failed[row, column, polarization] = trace_states == SampleState.FAILED
    states = np.full(grid.shape, StopState.MISSING, np.uint8)
    states[stored.any(axis=2)] = StopState.PARTLY
    states[stored.all(axis=2)] = StopState.DONE
    states[failed.any(axis=2)] = StopState.FAILED
    return states
