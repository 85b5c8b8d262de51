"""What belongs to the survey that GROUND shows: markers, image, candidates, hiding places."""

from __future__ import annotations

import uuid
from typing import Any, Callable, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.jobs.job import Job, JobState, Service
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.markers import Marker, present_markers
from gpr20_survey.results.answers import FocusedImage
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.results.hiding_map import HidingMap

# After a failure a survey is read again [s].
RETRY_S = 10.0


class AdditionsPresenter:
    """Knows what belongs to the survey that GROUND shows. Belongs to one thread.

    Args:
        imaging: Images and hiding maps of surveys, and the requests to the storage.
        author: Returns who makes markers now.

    Attributes:
        marking_failed: Called with the reason why a marker was not stored, or not removed.
        survey_id: The survey that is shown; empty: none.
        markers: Its markers.
        permittivity: That of the image which may be shown; None: any.
    """

    def __init__(self, imaging: Imaging, author: Callable[[], str]) -> None:
        self._imaging, self._author, self.pictures = imaging, author, imaging.pictures
        self._reading: Job[StoredSurvey] = imaging.job(Service.READ, self._take)
        self.marking_failed: Callable[[Message], None] = lambda _reason: None
        self.survey_id = ""
        self.markers: Tuple[Marker, ...] = ()
        self.permittivity: Optional[float] = None
        self._revision = 0
        self._can_read = False

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
            self._show(())
            self._reading.end()
            self.read_again()

    def read_again(self) -> None:
        """Read what belongs to the survey again: others may have added to it."""
        if self.can_mark:
            self._reading.ask(survey=self.survey_id)

    def refresh(self) -> None:
        """Ask again some time after a failure."""
        if self._reading.state is JobState.FAILED and self._reading.age_s > RETRY_S:
            self.read_again()

    def add_marker(
        self, survey: str, x_mm: float, y_mm: float, depth_mm: Optional[float], text: str
    ) -> None:
        """Ask the storage to add a marker with one line of text; depth None: not known.

        Another survey may be shown since its place was touched.

        Raises:
            InvalidValueError: The text or the place is not allowed.
        """
        marker = Marker(str(uuid.uuid4()), x_mm, y_mm, depth_mm, text, self._author())
        self._change(survey, Kind.MARKER, marker.request())

    def remove_marker(self, marker_id: str) -> None:
        """Ask the storage to remove a marker."""
        values = {"marker_id": marker_id, "author": self._author()}
        self._change(self.survey_id, Kind.MARKER_REMOVED, values)

    def _change(self, survey: str, kind: Kind, values: Mapping[str, Any]) -> None:
        # A job for each: one that is asked for while another runs must not end that.
        job = self._imaging.job(
            Service.FACT, lambda _said: self.read_again(), lambda why: self.marking_failed(why)
        )
        job.ask(survey=survey, kind=kind, values=values)

    def _take(self, stored: StoredSurvey) -> None:
        try:
            description = parse_object(stored.text, "metadata_json", MAX_FILE_BYTES)
            self._show(present_markers(description))
        except (SurveyRefusedError, InvalidValueError) as error:
            self._reading.refuse(error.message)

    def _show(self, markers: Tuple[Marker, ...]) -> None:
        self.markers = markers
        self._revision += 1
