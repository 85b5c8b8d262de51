"""Between the storage and GROUND: markers, related surveys, candidates, a finer plan."""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from functools import singledispatchmethod
from typing import Callable, Optional, Protocol, Tuple

from gpr20_common.message import Message
from gpr20_operator.ground.finer_plan import FinerPlan
from gpr20_operator.ground.geometry import Area
from gpr20_operator.jobs.pictures import Pictures
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_survey.results.hiding_map import HidingMap

# How often a survey is asked for again after a failure, in refreshes of 200 ms.
RETRY_REFRESHES = 50


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


class AdditionsPresenter:
    """Knows what belongs to the survey that GROUND shows. Belongs to one thread.

    Args:
        source: The storage.
        author: Returns who makes markers now.
        pictures: Images and hiding maps of surveys.

    Attributes:
        survey_id: The survey that is shown; empty: none.
        markers: Its markers.
        related: The surveys that refine it, and the one that it refines.
        plan: A finer survey that is planned, but did not begin yet.
        permittivity: That of the image which may be shown; None: any.
    """

    def __init__(
        self,
        source: AdditionsSource,
        author: Callable[[], str],
        pictures: Optional[Pictures] = None,
    ) -> None:
        self._source, self._author = source, author
        self.pictures = pictures or Pictures()
        self.survey_id = ""
        self.markers: Tuple[Marker, ...] = ()
        self.related: Tuple[RelatedSurvey, ...] = ()
        self.plan: Optional[FinerPlan] = None
        self.permittivity: Optional[float] = None
        self._revision = 0
        self._can_read = False
        # After so many refreshes it is read again; 0: not at all.
        self._due = 0

    @property
    def revision(self) -> Tuple[int, int]:
        """Changes with everything that a view shows of this."""
        return self._revision, self.pictures.revision

    @property
    def image(self) -> Optional[FocusedImage]:
        """The focused image of the survey that is shown; None: none yet.

        Nor is one that was made with another permittivity: its depths are others.
        """
        image = self.pictures.image(self.survey_id)
        if image is not None and self.permittivity in (None, image.found.permittivity):
            return image
        return None

    @property
    def hiding(self) -> Optional[HidingMap]:
        """Where a mine could hide in the survey that is shown; None: nobody asked."""
        return self.pictures.hiding(self.survey_id)

    @property
    def candidates(self) -> Tuple[Candidate, ...]:
        """The candidates of the survey that is shown."""
        image = self.image
        return () if image is None else image.found.shown()

    @property
    def can_mark(self) -> bool:
        """Whether the survey that is shown can have markers: the robot's storage holds it."""
        return bool(self.survey_id) and self._can_read

    def follow(self, survey_id: str, can_read: bool) -> None:
        """Show what belongs to another survey, if the storage can read it: not that of a replay."""
        if (survey_id, can_read) != (self.survey_id, self._can_read):
            self.survey_id, self._can_read = survey_id, can_read
            self._take((), ())
            self.read_again()

    def read_again(self) -> None:
        """Read what belongs to the survey again: others may have added to it."""
        self._due = 0
        if self.can_mark:
            self._source.read_additions(self.survey_id)

    def refresh(self) -> None:
        """Ask again some time after a failure."""
        if self._due:
            self._due -= 1
            if not self._due:
                self.read_again()

    @singledispatchmethod
    def on_event(self, event: object) -> None:
        """Take an event about additions; others are ignored."""

    @on_event.register
    def _(self, event: AdditionsRead) -> None:
        if event.survey_id == self.survey_id:
            self._take(event.markers, event.related)

    @on_event.register
    def _(self, event: MarkersStored) -> None:
        if event.survey_id == self.survey_id:
            self._take(event.markers, self.related)

    @on_event.register
    def _(self, event: AdditionsFailed) -> None:
        if event.survey_id == self.survey_id:
            self._due = RETRY_REFRESHES

    def add_marker(
        self, survey: str, x_mm: float, y_mm: float, depth_mm: Optional[float], text: str
    ) -> None:
        """Ask the storage to add a marker with one line of text; depth None: not known.

        Another survey may be shown since its place was touched.

        Raises:
            InvalidValueError: The text or the place is not allowed.
        """
        marker = Marker(str(uuid.uuid4()), x_mm, y_mm, depth_mm, text, self._author())
        self._source.add_marker(survey, marker)

    def remove_marker(self, marker_id: str) -> None:
        """Ask the storage to remove a marker."""
        self._source.remove_marker(self.survey_id, marker_id, self._author())

    def keep_plan(self, plan: Optional[FinerPlan]) -> None:
        """Keep a finer survey for later; None: it has begun, or is not wanted."""
        self.plan = plan
        self._revision += 1

    def _take(self, markers: Tuple[Marker, ...], related: Tuple[RelatedSurvey, ...]) -> None:
        self.markers, self.related = markers, related
        self._revision += 1
