"""What belongs to a survey besides its traces: markers, and the surveys that refine it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Tuple

from gpr20_common.message import Message
from gpr20_survey.plan.markers import Marker
from gpr20_user_interface.mid.map_geometry import Area


@dataclass(frozen=True)
class RelatedSurvey:
    """A survey that measured a part of another one more finely, or that other one.

    Attributes:
        folder: Name of its folder.
        is_finer: Whether it refines the survey it is related to; else it is refined by that.
        area: Its first to its last stop.
    """

    survey_id: str
    folder: str
    is_finer: bool
    area: Area


@dataclass(frozen=True)
class AdditionsRead:
    """What the storage knows of a survey besides its traces.

    Attributes:
        markers: Those that were not removed.
        related: The surveys that refine it, and the one that it refines.
    """

    survey_id: str
    markers: Tuple[Marker, ...]
    related: Tuple[RelatedSurvey, ...]


@dataclass(frozen=True)
class MarkersStored:
    """The markers of a survey, after one was added or removed durably."""

    survey_id: str
    markers: Tuple[Marker, ...]


@dataclass(frozen=True)
class AdditionsFailed:
    """What belongs to a survey cannot be read now."""

    survey_id: str
    reason: Message


@dataclass(frozen=True)
class MarkingFailed:
    """A marker could not be stored, or not be removed."""

    survey_id: str
    marker_id: str
    reason: Message


class AdditionsSource(Protocol):
    """Requests to the storage, without waiting; the answers come as events."""

    def read_additions(self, survey: str) -> None:
        """Ask for markers and related surveys of a survey, by its id."""

    def add_marker(self, survey: str, marker: Marker) -> None:
        """Ask to store a marker of a survey, by its id."""

    def remove_marker(self, survey: str, marker_id: str, author: str) -> None:
        """Ask to remove a marker of a survey, by its id."""
