"""What belongs to the survey that GROUND shows: markers, image, candidates, hiding places."""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from typing import Callable, Optional, Protocol, Tuple

from gpr20_common.message import Message
from gpr20_operator.jobs.pictures import Pictures
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_survey.results.hiding_map import HidingMap

# How often a survey is asked for again after a failure, in refreshes of 200 ms.
RETRY_REFRESHES = 50


@dataclass(frozen=True)
class MarkersStored:
    """The markers of a survey that are stored durably, and were not removed."""

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
        """Ask for the markers of a survey, by its id."""

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
        permittivity: That of the image which may be shown; None: any.
    """

    def __init__(
        self, source: AdditionsSource, author: Callable[[], str], pictures: Pictures
    ) -> None:
        self._source, self._author, self.pictures = source, author, pictures
        self.survey_id = ""
        self.markers: Tuple[Marker, ...] = ()
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
            self._take(())
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

    def on_event(self, event: object) -> None:
        """Take an event about additions of the survey that is shown; others are ignored."""
        if getattr(event, "survey_id", "") != self.survey_id:
            return
        if isinstance(event, MarkersStored):
            self._take(event.markers)
        elif isinstance(event, AdditionsFailed):
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

    def _take(self, markers: Tuple[Marker, ...]) -> None:
        self.markers = markers
        self._revision += 1
