"""One survey on map and radar, and which of its stored traces are still to be read."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import SurveyGrid
from gpr20_operator.ground.map_model import MapModel
from gpr20_operator.ground.trace_events import TracesRead
from gpr20_survey.trace.trace import Trace


class ShownSurvey:
    """A MapModel and a RadarModel of the same survey.

    Traces that the coverage lists as stored and the radar lacks are read from the storage: those
    from before this window was started, and those that the topic lost.
    """

    def __init__(self) -> None:
        self.map = MapModel()
        self.radar = RadarModel()
        self._lacking: Optional[int] = None

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
        if grid.survey_id == self.survey_id and grid.plan == self._plan():
            return
        self._lacking = None
        self.radar.begin(grid)
        self.map.set_grid(grid)

    def take_trace(self, trace: Trace) -> None:
        """Take a trace, if it is one of this survey.

        Raises:
            SurveyNotReadableError: It does not belong to its place in the plan.
        """
        if trace.survey_id == self.survey_id:
            self.radar.add(trace)

    def take_page(self, page: TracesRead) -> Tuple[Message, ...]:
        """Take traces that were read; return why some of them cannot be shown."""
        if page.survey != self.survey_id:
            return ()
        problems = []
        for index, reason in page.unreadable.items():
            self.radar.give_up(index, reason)
            problems.append(_about(index, reason))
        for trace in page.traces:
            try:
                self.radar.add(trace)
            except SurveyNotReadableError as error:
                problems.append(error.message)
        # Whatever the answer was, the same place is not requested again and again.
        if page.first_index in self._absent():
            reason = Message("the storage has no file of this trace")
            self.radar.give_up(page.first_index, reason)
            problems.append(_about(page.first_index, reason))
        self._lacking = None
        return tuple(problems)

    def next_page(self) -> Optional[int]:
        """Return the place in the plan from which to read traces; None: all are here.

        A trace that was stored just now may still come on the topic: it is requested only if it
        is missing at two calls in a row.
        """
        absent = self._absent()
        before, self._lacking = self._lacking, int(absent[0]) if absent.size else None
        return self._lacking if self._lacking is not None and self._lacking == before else None

    def _absent(self) -> np.ndarray:
        states = self.map.trace_states
        return np.zeros(0, np.intp) if states is None else self.radar.absent(states)

    def _plan(self) -> object:
        return None if self.map.grid is None else self.map.grid.plan


def _about(index: int, reason: Message) -> Message:
    return Message("trace {index}: {reason}", index=index, reason=reason)
