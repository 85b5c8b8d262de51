"""What a survey will do, and what of it is stored already."""

from __future__ import annotations

from dataclasses import dataclass
from typing import FrozenSet, List, Optional, Sequence

from gpr20_survey.plan.survey_plan import SurveyPoint
from gpr20_survey.trace.trace import Trace


@dataclass(frozen=True)
class SurveyPlan:
    """What a survey will do.

    Attributes:
        survey_id: UUID.
        points: All points in the order of their visit.
        durations_s: How long each takes [s].
        stored: Points that are on the disk already, of a survey that is resumed.
        last: The trace of them that was stored last.
    """

    survey_id: str
    points: Sequence[SurveyPoint]
    durations_s: Sequence[float]
    stored: FrozenSet[int] = frozenset()
    last: Optional[Trace] = None

    @property
    def pending(self) -> List[SurveyPoint]:
        """The points that are not stored yet."""
        return [point for point in self.points if point.index not in self.stored]

    @property
    def pending_durations_s(self) -> List[float]:
        """How long the points that are not stored yet take [s]."""
        return [self.durations_s[point.index] for point in self.pending]
