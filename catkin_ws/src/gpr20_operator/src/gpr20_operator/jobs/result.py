"""The result of one survey: its places, where a mine could hide, what was found, and its report."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from typing import Callable, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.grid import SurveyGrid, grid_from_description
from gpr20_operator.jobs.job import Job, JobState, Service
from gpr20_operator.jobs.pictures import Exported, Imaging, Sticks, StoredSurvey
from gpr20_survey.folder.log_record import Kind, log_values, soil_values
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import FOUND_FORMAT, Found, What, found_of, present
from gpr20_survey.results.answers import ExportPart, FocusedImage, Volume
from gpr20_survey.results.candidates import Candidate, CandidateList, json_text
from gpr20_survey.results.hiding_map import HidingMap, Targets
from gpr20_survey.trace import utc_time

PLACES_SHOWN = 5
# Places of two lists that are no farther apart are one.
BESIDE_MM = 30.0
CANCELLED = Message("The search was cancelled.")
SURVEY_RUNS = Message("A survey is running. The search begins when it has ended.")
OTHER_SURVEY = Message("The answer is that of another survey.")
CANCELLING = Message("Cancelling. Unfinished files are removed from the stick.")
# A stick that is plugged in shows within this time [s].
LIST_PERIOD_S = 2.0
NO_STICKS = Sticks("", ())
REPORT = (ExportPart.REPORT_HTML,)
ALL_DATA = (ExportPart.REPORT_HTML, ExportPart.CANDIDATES_CSV, ExportPart.SURVEY_ZIP)


@dataclass(frozen=True)
class Record:
    """What the storage says of a survey.

    Attributes:
        grid: Where its traces are, its id, and whether it is simulated.
        stored: How many traces are stored.
        outcome: How it ended, as in survey.json; empty: it runs, or was cut off.
        name: What people call it; empty: nothing.
        operator: Who measured; empty: it is not known.
        started: When, ISO 8601, UTC; empty: it is not known.
        found: What people found at its candidates.
    """

    grid: SurveyGrid
    stored: int
    outcome: str = ""
    name: str = ""
    operator: str = ""
    started: str = ""
    found: Tuple[Found, ...] = ()
    unreadable: int = 0

    @property
    def survey_id(self) -> str:
        """UUID of the survey."""
        return self.grid.survey_id


def record_of(stored: StoredSurvey) -> Record:
    """Return what the storage says of a survey.

    Raises:
        SurveyNotReadableError: It says nothing that is readable.
        InvalidValueError: Its annotation is not as it should be.
    """
    grid = grid_from_description(stored.text)
    values = parse_object(stored.text, "metadata_json", MAX_FILE_BYTES)
    unreadable = 0
    finds = []
    for noted in log_values(values, Kind.FOUND):
        if noted.get("format") == FOUND_FORMAT:
            try:
                finds.append(found_of(noted))
            except InvalidValueError:
                # Counted: a person learns of it, and the places stay.
                unreadable += 1
    annotation = annotation_of(values)
    return Record(
        grid,
        len(stored.stored_indices),
        str(values.get("outcome") or ""),
        annotation.name or annotation.site,
        annotation.operator,
        str(values.get("started") or ""),
        tuple(present(finds)),
        unreadable,
    )


def list_sum(found: CandidateList) -> str:
    """Return the SHA-256 of the file that `gpr20 candidates` writes of a list."""
    return hashlib.sha256((json_text(found) + "\n").encode()).hexdigest()


class StickExport:
    """Writes a survey to the stick that a person touches, one at a time. Belongs to one thread.

    Attributes:
        job: The export.
        listing: The request for the sticks.
        sticks: Those that are mounted, and where.
        survey: Id of the survey that is exported.
    """

    def __init__(self, imaging: Imaging) -> None:
        self.job: Job[Exported] = imaging.job(Service.EXPORT)
        self.listing: Job[Sticks] = imaging.job(Service.STICKS, self._take_sticks)
        self.sticks, self.survey = NO_STICKS, ""

    @property
    def revision(self) -> Tuple[object, ...]:
        """Changes with everything that a view shows of this."""
        return self.job.revision, self.listing.problem, self.sticks

    def begin(self) -> None:
        """Look for sticks again: a listed one may have been removed."""
        if not self.job.running:
            self.job.end()
            self.sticks = NO_STICKS
            self.listing.ask()

    def look_for_sticks(self) -> None:
        """Ask for the sticks again if that was not done just now."""
        busy = self.job.running or self.listing.running
        if not busy and self.listing.age_s >= LIST_PERIOD_S:
            self.listing.ask()

    def write(
        self, volume: Volume, survey: str, parts: Tuple[ExportPart, ...], language: str
    ) -> None:
        """Write files of a survey to a stick."""
        if not self.job.running:
            self.survey = survey
            kinds = [one.value for one in parts]
            self.job.ask(survey=survey, kinds=kinds, language=language, volume=volume.path)

    def _take_sticks(self, sticks: Sticks) -> None:
        self.sticks = sticks


class SurveyResult:
    """Reads a survey, then searches it, and asks about it with the permittivity that is stored.

    Nothing is searched while a survey runs. Belongs to one thread.

    Args:
        imaging: The imaging node and the storage, and the pictures that all pages share.
        time_us: The time of day [us since 1970].

    Attributes:
        survey: Id or folder of the survey in question; empty: none.
        latest_id: The survey that the robot measures, or measured last; empty: none.
        record: What the storage says of it; None: that is not known yet.
        reading: The request for it.
        search: The request for image and candidates.
        hiding: The request for where the target could hide.
        noting: The request to store what was found.
        soil: The request to store another permittivity.
        export: The export to a stick.
        target: The target that could hide.
        survey_runs: Whether the robot measures: nothing is searched, made or entered meanwhile.
        first: Number of the first place that is shown, from 0.
        chosen: The place in question; None: none.
    """

    def __init__(self, imaging: Imaging, time_us: Callable[[], int] = time_of_day_us) -> None:
        self._imaging, self._time_us = imaging, time_us
        self.survey_runs = self._wanted = False
        self.survey = self.latest_id = self._list_sum = ""
        self.record: Optional[Record] = None
        self.reading: Job[StoredSurvey] = imaging.job(Service.READ, self._take_record)
        self.search: Job[FocusedImage] = imaging.job(Service.FOCUS, self._take_image)
        self.hiding: Job[HidingMap] = imaging.job(Service.HIDE, self._take_hiding)
        self.noting: Job[Message] = imaging.job(Service.FACT, lambda _said: self._read_again())
        self.soil: Job[Message] = imaging.job(Service.FACT, lambda _said: self.try_again())
        self._jobs = (self.reading, self.search, self.hiding, self.noting, self.soil)
        self.export = StickExport(imaging)
        self.target = Targets.TYPE_72.value
        self.first = 0
        self.chosen: Optional[Candidate] = None

    @property
    def revision(self) -> Tuple[object, ...]:
        """Changes with everything that a view shows of this."""
        return (
            *(self.survey, self.latest_id, self.survey_runs, self.first, self.chosen),
            *(one.revision for one in self._jobs),
            *(self.target, self.export.revision),
        )

    @property
    def permittivity(self) -> Optional[float]:
        """Of the ground, as stored with the survey; None: nobody entered one."""
        return None if self.record is None else self.record.grid.permittivity

    @property
    def image(self) -> Optional[FocusedImage]:
        """The image that the places are in; None: the search is not done."""
        return self.search.result

    @property
    def places(self) -> Tuple[Candidate, ...]:
        """The places to check, then the weaker echoes."""
        return () if self.image is None else self.image.found.candidates

    @property
    def shown(self) -> Tuple[Candidate, ...]:
        """At most five of the places to check, or of the weaker echoes."""
        last = self.first + PLACES_SHOWN
        if self.image is not None and self.first < self.image.found.primary:
            last = min(last, self.image.found.primary)
        return self.places[self.first : last]

    @property
    def waits(self) -> bool:
        """Whether the search begins when the survey that runs has ended."""
        return self.survey_runs and self.image is None

    def open(self, survey: str) -> None:
        """Show the result of a survey, by its id or folder; of the present one, what is known."""
        if survey != self.survey:
            self.survey = survey
            self.try_again()

    def end(self) -> None:
        """End everything but an export, which continues with its survey."""
        for job in self._jobs:
            job.end()

    def try_again(self) -> None:
        """Forget what is known of the survey; read and search it again."""
        self.end()
        if self.record is not None:
            self._imaging.pictures.drop_hiding(self.record.survey_id)
        self.record, self.chosen, self.first = None, None, 0
        self._wanted = bool(self.survey)

    def note_running(self, runs: bool) -> None:
        """Note whether a survey is running: what searches ends when one begins."""
        # It may be this one that is resumed. In the end what nobody has found is searched for.
        if runs != self.survey_runs and (runs or self.image is None):
            self.try_again()
        self.survey_runs = runs

    def keep(self) -> None:
        """Ask for what is lacking, and while a survey runs only for what is known.

        It is called while somebody looks at the result.
        """
        survey = self.survey if self.record is None else self.record.survey_id
        if not survey or not self._wanted or (self.survey_runs and survey == self.latest_id):
            return
        if self.record is None:
            if self.reading.state is JobState.READY:
                self.reading.ask(survey=survey)
            return
        self._wanted = False
        known = {"only_known": True} if self.survey_runs else {}
        self.search.ask(survey=survey, **known)

    def cancel(self) -> None:
        """End the search."""
        self._wanted = False
        self.reading.end()
        self.search.end(CANCELLED)

    def set_permittivity(self, permittivity: Optional[float]) -> None:
        """Store another permittivity, None: not known; once it is stored, search with it."""
        if self.record is not None and permittivity != self.permittivity and not self.soil.running:
            values = soil_values(permittivity, self._time_us())
            self.soil.ask(survey=self.record.survey_id, kind=Kind.DECISION, values=values)

    def choose_target(self, target: Targets) -> None:
        """Ask where a target could hide."""
        if self.record is None or self.survey_runs:
            return
        self.target = target.value
        self.hiding.ask(survey=self.record.survey_id, target=target.value.name)

    def turn_page(self) -> None:
        """Show the next five places; after them the weaker echoes, and the first ones again."""
        self.first += len(self.shown)
        if self.first >= len(self.places):
            self.first = 0
        self.chosen = None

    def find_at(self, place: Candidate) -> Optional[Found]:
        """Return what people found at a place of this list, or last at one of another list near it.

        A list that was made with another permittivity has other numbers. What was found at one
        place of this list says nothing about the place beside it, or below it.
        """
        records = () if self.record is None else self.record.found
        own = [
            one for one in records if (one.candidate, one.list_sha256) == (place.id, self._list_sum)
        ]
        near = [
            one
            for one in records
            if one.list_sha256 != self._list_sum
            and math.hypot(one.x_mm - place.x_mm, one.y_mm - place.y_mm) <= BESIDE_MM
        ]
        return max(own or near, key=lambda one: one.time) if own or near else None

    def note_found(self, place: Candidate, what: What, depth_mm: Optional[float], who: str) -> None:
        """Store durably what people found at a place.

        Raises:
            InvalidValueError: A value is not allowed.
        """
        if self.record is None or self.noting.running:
            return
        found = Found(
            *(what, place.id, self._list_sum, place.x_mm, place.y_mm, who),
            *(utc_time.iso_text(self._time_us()), depth_mm),
        )
        self.noting.ask(survey=self.record.survey_id, kind=Kind.FOUND, values=found.values())

    def _read_again(self) -> None:
        if self.record is not None:
            self.reading.ask(survey=self.survey)

    def _take_record(self, stored: StoredSurvey) -> None:
        try:
            self.record = record_of(stored)
        except (SurveyNotReadableError, InvalidValueError) as error:
            self.reading.refuse(error.message)

    def _take_image(self, image: FocusedImage) -> None:
        if self._is_other(image.found.survey_id):
            self.search.refuse(OTHER_SURVEY)
            return
        self._list_sum = list_sum(image.found)
        self._imaging.pictures.add_image(image)

    def _take_hiding(self, found: HidingMap) -> None:
        if self._is_other(found.survey_id):
            self.hiding.refuse(OTHER_SURVEY)
            return
        self._imaging.pictures.add_hiding(found)

    def _is_other(self, survey_id: str) -> bool:
        return self.record is None or survey_id != self.record.survey_id
