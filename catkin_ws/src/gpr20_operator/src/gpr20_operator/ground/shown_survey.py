"""One survey on map and radar, and which of its stored traces are still to be read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby
from typing import Iterable, List, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_operator.ground.coverage import MapModel
from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import SurveyGrid
from gpr20_operator.ground.trace_events import TracesRead
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.trace_block import TraceBlock

NOTHING = np.zeros(0, np.intp)
# What the storage answers at once at most.
TRACES_PER_BLOCK = 1000
# How many stops are read before the others.
COARSE_STOPS = 500


@dataclass(frozen=True)
class Loading:
    """How far the stored traces of a survey have been read.

    A stop that waits is "loading", never "not measured": what is not here yet says nothing about
    the ground. It is over when `loaded` is `stored`. A trace that a running survey has just stored
    waits, too, for a fraction of a second.

    Attributes:
        loaded: How many traces are here.
        stored: How many will be: all that are stored, but those that cannot be shown
            (`RadarModel.given_up`).
        waiting: Which stored traces are not here yet (bool, polarizations x rows x columns).
        step: Of a survey that is opened every `step`-th row and column is read first, from row and
            column 0 on: a picture may draw these stops `step` times as wide while it loads.
    """

    loaded: int
    stored: int
    waiting: np.ndarray
    step: int


NOT_LOADING = Loading(0, 0, np.zeros((0, 0, 0), bool), 1)


class ShownSurvey:
    """A MapModel and a RadarModel of the same survey.

    Traces that the coverage lists as stored and the radar lacks are read from the storage: those
    from before this window was started, and those that the topic lost.
    """

    def __init__(self) -> None:
        self.map = MapModel()
        self.radar = RadarModel()
        self._lacking = NOTHING
        self._loading = (-1, -1), NOT_LOADING

    @property
    def survey_id(self) -> str:
        """UUID; empty while no plan is known."""
        grid = self.map.grid
        return "" if grid is None else grid.survey_id

    def begin(self, grid: SurveyGrid) -> None:
        """Show the survey of a plan; one that is shown already stays as it is.

        Raises:
            SurveyNotReadableError: Its coverage contradicts the plan.
        """
        own = self.map.grid
        if own is None or (own.survey_id, own.plan) != (grid.survey_id, grid.plan):
            self._lacking = NOTHING
            self.radar.begin(grid)
            self.map.set_grid(grid)
        else:
            own.permittivity = grid.permittivity

    def take_traces(self, traces: Iterable[Trace]) -> Tuple[Message, ...]:
        """Take those traces that are of this survey; return why some of them cannot be shown.

        Many at once take hardly longer than one.
        """
        # One that came twice is in no block twice: the last one counts.
        own = {one.index: one for one in traces if one.survey_id == self.survey_id}
        problems: List[Message] = []
        for _same, some in groupby(own.values(), lambda one: one.frequency_hz.tobytes()):
            problems += self.radar.add_block(TraceBlock.of(self.survey_id, list(some)))
        return tuple(problems)

    def take_block(self, read: TracesRead) -> Tuple[Message, ...]:
        """Take traces that were read; return why some of them cannot be shown."""
        if read.block.survey_id != self.survey_id:
            return ()
        unreadable = dict(read.unreadable)
        problems = [*self.radar.add_block(read.block)]
        # Whatever the answer was, the same place is not requested again and again.
        if read.first_index in self._absent() and read.first_index not in unreadable:
            unreadable[read.first_index] = Message("the storage has no file of this trace")
        for index, reason in unreadable.items():
            self.radar.give_up(index, reason)
            problems.append(Message("trace {index}: {reason}", index=index, reason=reason))
        return tuple(problems)

    def due(self) -> Tuple[int, ...]:
        """Return the places in the plan whose traces to read now; empty: all are here.

        Some that are spread over the area come first, then row after row. A trace that was stored
        just now may still come on the topic: it is due only if it is absent at two calls in a row.
        """
        absent = self._absent()
        due = absent[np.isin(absent, self._lacking)]
        self._lacking = absent
        if self.map.grid is not None:
            row, column, _polarization = self.map.grid.cells(due)
            step = coarse_step(self.map.grid)
            spread = due[(row % step == 0) & (column % step == 0)]
            due = spread if spread.size else due
        return tuple(due[:TRACES_PER_BLOCK].tolist())

    @property
    def loading(self) -> Loading:
        """How much of what is stored is here."""
        revisions = (self.map.revision, self.radar.revision)
        if self._loading[0] != revisions:
            self._loading = revisions, self._compared()
        return self._loading[1]

    def _compared(self) -> Loading:
        grid, count, absent = self.map.grid, self.radar.count, self._absent()
        if grid is None:
            return NOT_LOADING
        row, column, polarization = grid.cells(absent)
        waiting = np.zeros((len(grid.rotations_deg), *grid.shape), bool)
        waiting[polarization, row, column] = True
        return Loading(count, count + len(absent), waiting, coarse_step(grid))

    def _absent(self) -> np.ndarray:
        states = self.map.trace_states
        return NOTHING if states is None else self.radar.absent(states)


def coarse_step(grid: SurveyGrid) -> int:
    """Return the distance of the rows and columns that are read before the others."""
    return max(1, round(math.sqrt(grid.shape[0] * grid.shape[1] / COARSE_STOPS)))
