"""What belongs to the survey that GROUND shows: markers, image, candidates, hiding places."""

from __future__ import annotations

import math
import uuid
from typing import Any, Callable, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.ground.grid import SurveyGrid
from gpr20_operator.ground.traces import RETRY_S
from gpr20_operator.jobs.job import Job, JobState, Service
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.log_record import Kind, soil_of_survey
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.markers import Marker, present_markers
from gpr20_survey.results.answers import FocusedImage
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.results.hiding_map import HidingMap


class AdditionsPresenter:
    """Knows what belongs to the survey that GROUND shows. Belongs to one thread.

    Args:
        imaging: Images and hiding maps of surveys, and the requests to the storage.
        author: Returns who makes markers now.

    Attributes:
        marking_failed: Called with the reason why a marker was not stored, or not removed.
        survey_id: The survey that is shown; empty: none.
        markers: Its markers.
        permittivity: Of the ground, as stored with the survey; None: it is not known.
    """

    def __init__(self, imaging: Imaging, author: Callable[[], str]) -> None:
        self._imaging, self._author, self.pictures = imaging, author, imaging.pictures
        self._reading: Job[StoredSurvey] = imaging.job(Service.READ, self._take)
        self.marking_failed: Callable[[Message], None] = lambda _reason: None
        self.survey_id = ""
        self.markers: Tuple[Marker, ...] = ()
        self.permittivity: Optional[float] = None
        self._revision = 0

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

    def follow(self, grid: Optional[SurveyGrid]) -> None:
        """Show what belongs to the survey of a plan; None: to none."""
        survey_id = "" if grid is None else grid.survey_id
        if survey_id != self.survey_id:
            self.survey_id = survey_id
            self._show((), None if grid is None else grid.permittivity)
            self._reading.end()

    def read_again(self) -> None:
        """Read what belongs to the survey again: others may have added to it."""
        if self.survey_id:
            self._reading.ask(survey=self.survey_id)

    def refresh(self, again_s: float = math.inf) -> None:
        """Ask for what belongs to the survey; again after a time, and sooner after a failure."""
        reading = self._reading
        limit_s = {JobState.READY: 0.0, JobState.FAILED: RETRY_S, JobState.DONE: again_s}
        if reading.age_s >= limit_s.get(reading.state, math.inf):
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
            soil = soil_of_survey(description)
            markers = present_markers(description)
            self._show(markers, None if soil is None else soil.permittivity)
        except (SurveyRefusedError, InvalidValueError) as error:
            self._reading.refuse(error.message)

    def _show(self, markers: Tuple[Marker, ...], permittivity: Optional[float]) -> None:
        if (markers, permittivity) != (self.markers, self.permittivity):
            self.markers, self.permittivity = markers, permittivity
            self._revision += 1
