"""Events about the traces of surveys, running and past, besides Trace and CoverageRuns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Tuple, Union

from gpr20_common.message import Message
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.trace_block import TraceBlock


@dataclass(frozen=True)
class SurveyDescribed:
    """The storage has opened a survey; its survey.json as it was then."""

    text: str


@dataclass(frozen=True)
class SurveyRead:
    """The plan of a past survey, and which of its traces are stored."""

    folder: str
    text: str
    stored_indices: Tuple[int, ...]


@dataclass(frozen=True)
class TracesRead:
    """Stored traces, from a place in the plan on, and why others cannot be read, by theirs."""

    first_index: int
    block: TraceBlock
    unreadable: Mapping[int, Message]


@dataclass(frozen=True)
class SurveysListed:
    """A page of the list of past surveys, the newest first."""

    before: str
    surveys: Tuple[SurveySummary, ...]
    more: bool


@dataclass(frozen=True)
class ReadingFailed:
    """Something that was requested cannot be read now."""

    reason: Message


TraceEvent = Union[
    Trace,
    CoverageRuns,
    SurveyDescribed,
    SurveyRead,
    TracesRead,
    SurveysListed,
    ReadingFailed,
]
