"""What is told of the traces of surveys, running and past, beside RadarTrace and CoverageRuns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Tuple, Union

from gpr20_user_interface.mid.map_coverage import CoverageRuns
from gpr20_user_interface.mid.past_surveys import PastSurvey
from gpr20_user_interface.mid.radar_model import RadarTrace


@dataclass(frozen=True)
class SurveyDescribed:
    """The storage has opened a survey; its survey.json as it was then."""

    text: str


@dataclass(frozen=True)
class SurveyRead:
    """What was to be measured in a past survey, and what of it is stored."""

    folder: str
    text: str
    stored_indices: Tuple[int, ...]


@dataclass(frozen=True)
class TracesRead:
    """Stored traces that were asked for, in the order of the plan."""

    survey: str
    first_index: int
    traces: Tuple[RadarTrace, ...]
    unreadable: Tuple[str, ...]


@dataclass(frozen=True)
class SurveysListed:
    """A page of the list of past surveys, the newest first."""

    before: str
    surveys: Tuple[PastSurvey, ...]
    more: bool


@dataclass(frozen=True)
class ReadingFailed:
    """Something that was asked for cannot be read now."""

    reason: str


TraceEvent = Union[
    RadarTrace, CoverageRuns, SurveyDescribed, SurveyRead, TracesRead, SurveysListed, ReadingFailed
]


class TraceSource(Protocol):
    """The storage, asked without waiting; what it answers comes as events."""

    def list_surveys(self, before: str) -> None:
        """Ask for the surveys older than a folder; empty: for the newest."""

    def read_survey(self, folder: str) -> None:
        """Ask what a past survey was to measure."""

    def read_traces(self, survey: str, first_index: int) -> None:
        """Ask for a page of stored traces of a survey, by its id."""
