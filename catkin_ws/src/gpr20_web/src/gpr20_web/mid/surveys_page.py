"""SURVEYS: the stored surveys as the window lists them, what people add to them, and downloads."""

from __future__ import annotations

import contextlib
import threading
import uuid
import zipfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, Mapping, Optional, Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.job import Service
from gpr20_operator.jobs.pictures import SURVEYS_PER_PAGE
from gpr20_operator.jobs.result import list_sum
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.errors import storing
from gpr20_survey.files.durable_files import writer_of
from gpr20_survey.files.regular_files import PIECE_BYTES, add_folder, regular_files
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import Marker, What
from gpr20_survey.results.answers import ExportPart, SurveySummary
from gpr20_survey.trace import utc_time
from gpr20_web.calls import Body, Call, Role, Route, WebPage, sentence, text_of
from gpr20_web.faults import BadRequestError, BusyError, NotNowError, no_survey
from gpr20_web.mid import survey_values
from gpr20_web.mid.survey_values import Ask, OpenedSurvey

SURVEY = f"/api/surveys/(?P<folder>{survey_folder.FOLDER_NAME.pattern})"
MADE = "|".join(one.value for one in ExportPart if one is not ExportPart.SURVEY_ZIP)
OTHERS_BY_NOW = Message("the candidates are not known, or others by now: search the survey first")
SURVEY_RUNS = Message("A survey is running. This is possible when it has ended.")
AT_WORK = Message("The imaging node is at work already. Wait for its answer.")
UNREADABLE = Message("the survey could not be read")


@dataclass(frozen=True)
class _Find:
    """What was found at a candidate of a list, and how deep [mm]."""

    candidate: str
    list: str
    what: What
    depth_mm: Optional[float] = None


class SurveysPage(WebPage):
    """The stored surveys.

    Args:
        ask: Asks storage and imaging node.
        cancel: Asks to end a request, by its id, without waiting.
        data: The data folder, on this computer.
    """

    words: Mapping[str, Message] = {
        "title": Message("Surveys"),
        "search": Message("Search"),
        "hint": Message("Name, site, operator, date"),
        "older": Message("Older"),
        "none": Message("No survey fits the search."),
        "simulated": Message("SIMULATED"),
        "notes": Message("Notes"),
        "add": Message("Add"),
        "depth": Message("Depth (mm), if known"),
        "text": Message("Text"),
        "found": Message("Found"),
        "candidates": Message("Candidates"),
        "weak": Message("weaker echo"),
        "find": Message("Search for candidates"),
        "searching": texts.SEARCHING,
        "downloads": Message("Downloads"),
        "whole": Message("whole survey as ZIP"),
        "report-html": Message("report as HTML"),
        "candidates-csv": Message("candidates as CSV"),
        "candidates-geojson": Message("candidates as GeoJSON"),
        "making": Message("The file is being made; this takes about a minute."),
        **{one.value: text for one, text in texts.FINDS.items()},
    }

    def __init__(
        self,
        ask: Ask,
        cancel: Callable[[str], None],
        data: Path,
        time_us: Callable[[], int] = time_of_day_us,
    ) -> None:
        self._ask, self._cancel = ask, cancel
        self._data, self._time_us = data, time_us
        self._running = ""
        self._working, self._work_id = threading.Lock(), uuid.uuid4().hex
        self.routes = tuple(
            Route(method, pattern, Role.WATCH, answer, blocking=True)
            for method, pattern, answer in (
                ("GET", "/api/surveys", self._list),
                ("GET", SURVEY, self._details),
                ("POST", f"{SURVEY}/notes", self._add_note),
                ("POST", f"{SURVEY}/markers", self._add_marker),
                ("POST", f"{SURVEY}/found", self._add_found),
                ("POST", f"{SURVEY}/candidates", self._search),
                ("GET", f"{SURVEY}/zip", self._whole),
                ("GET", f"{SURVEY}/made/(?P<kind>{MADE})", self._made),
            )
        )

    def show_state(self, snapshot: Snapshot) -> None:
        """Follow which survey runs: nothing is searched meanwhile."""
        if snapshot.running_survey and not self._running and self._working.locked():
            self._cancel(self._work_id)
        self._running = snapshot.running_survey

    def _folder(self, call: Call) -> Path:
        return folder_of(self._data, call.parts["folder"])

    def _past(self, before: str, most: int) -> PastSurveys:
        past = PastSurveys()
        past.set_running(self._running)
        page = self._ask(Service.LIST, before=before, max_surveys=most)
        past.take("", page.surveys, page.more)
        return past

    def _survey(self, call: Call) -> Tuple[PastSurveys, SurveySummary]:
        folder = self._folder(call).name
        # Of what comes before it in the order of names, the first is the folder itself.
        past = self._past(f"{folder}~", 1)
        survey = past.find(folder)
        if survey is None:
            raise no_survey(folder)
        return past, survey

    def _analysed(self, call: Call) -> SurveySummary:
        past, survey = self._survey(call)
        if past.can_analyze(survey):
            return survey
        raise NotNowError(SURVEY_RUNS if self._running else survey.problem or past.ending(survey))

    def _list(self, call: Call) -> Mapping[str, Any]:
        before, text = text_of(call, "before"), text_of(call, "text")
        if before and not survey_folder.FOLDER_NAME.fullmatch(before):
            raise BadRequestError(Message("before is the folder of a survey"))
        past = self._past(before, SURVEYS_PER_PAGE)
        found = past.found(text, call.text)
        return {
            "surveys": [survey_values.row_of(past, one, call.text) for one in found],
            "next": past.next_before if past.more else "",
        }

    def _details(self, call: Call) -> Mapping[str, Any]:
        past, survey = self._survey(call)
        shown = {
            **survey_values.row_of(past, survey, call.text),
            "lines": [sentence(call.text, one) for one in texts.survey_lines(past, survey)],
            "can_open": past.can_open(survey),
            "can_search": past.can_analyze(survey),
        }
        problems = [survey.problem]
        try:
            shown["bytes"] = size_of(self._folder(call))
        except Gpr20Error as error:
            problems.append(error.message)
        if survey.problem is None:
            opened = OpenedSurvey(self._ask, survey.folder, only_known=True)
            shown.update(survey_values.result_of(opened.result, call.text))
            problems.append(opened.result.reading.problem)
            try:
                shown.update(survey_values.written_of(opened.stored, call.text))
            except Gpr20Error as error:
                problems.append(error.message)
        return {**shown, "problems": [sentence(call.text, one) for one in problems if one]}

    def _add_note(self, call: Call) -> Mapping[str, Any]:
        folder, text = self._folder(call).name, text_of(call, "text").strip()
        if not text:
            raise BadRequestError(Message("the note is empty"), fault=NOT_ALLOWED)
        when = utc_time.iso_text(self._time_us())[:16].replace("T", " ")
        # The other lines of a note are indented: none can look like the note of somebody else.
        line = f"{when} UTC, {call.who.name}: " + "\n    ".join(text.splitlines())
        stored = self._ask(Service.READ, survey=folder)
        before = annotation_of(parse_object(stored.text, "metadata_json", MAX_FILE_BYTES))
        after = replace(before, notes=f"{before.notes}\n{line}".lstrip("\n"))
        # The storage keeps what others have written since.
        values = {**after.values(), "notes_before": before.notes}
        self._add_fact(folder, Kind.ANNOTATION, values)
        return {}

    def _add_marker(self, call: Call) -> Mapping[str, Any]:
        place: Dict[str, Any] = {one: call.values.get(one) for one in ("x_mm", "y_mm", "depth_mm")}
        people = {"text": text_of(call, "text"), "author": call.who.name}
        marker = record_from(Marker, {"marker_id": str(uuid.uuid4()), **place, **people}, "marker")
        self._add_fact(self._folder(call).name, Kind.MARKER, marker.request())
        return {}

    def _add_fact(self, folder: str, kind: Kind, values: Mapping[str, Any]) -> None:
        self._ask(Service.FACT, survey=folder, kind=kind, values=values)

    def _add_found(self, call: Call) -> Mapping[str, Any]:
        folder, find = self._folder(call).name, record_from(_Find, call.values, "found")
        result = OpenedSurvey(self._ask, folder, only_known=True).result
        known = result.image is not None and list_sum(result.image.found)
        places = result.places if known == find.list else ()
        place = next((one for one in places if one.id == find.candidate), None)
        if place is None:
            raise NotNowError(result.reading.problem or OTHERS_BY_NOW)
        result.note_found(place, find.what, find.depth_mm, call.who.name)
        if result.noting.problem is not None:
            raise NotNowError(result.noting.problem)
        return {}

    def _search(self, call: Call) -> Mapping[str, Any]:
        """Return what is found in a survey; whoever asks later gets the same."""
        folder = self._analysed(call).folder
        with self._at_work():
            result = OpenedSurvey(self._ask, folder, request_id=self._work_id).result
        problem = result.reading.problem or result.search.problem
        if problem is not None:
            raise NotNowError(problem)
        return survey_values.result_of(result, call.text)

    def _whole(self, call: Call) -> Body:
        """Return a ZIP file of a survey, which is made while it is sent."""
        folder = self._folder(call)
        size_of(folder)
        return Body(zip_parts(folder), "application/zip", f"{folder.name}_survey.zip")

    def _made(self, call: Call) -> Body:
        """Return a file that the imaging node makes."""
        folder = self._analysed(call).folder
        options = {"language": call.language.value, "volume": ""}
        wanted = {"request_id": self._work_id, "kinds": [call.parts["kind"]], **options}
        with self._at_work():
            made = self._ask(Service.EXPORT, survey=folder, **wanted)
        return Body(made.content, "application/octet-stream", made.files[0])

    @contextlib.contextmanager
    def _at_work(self) -> Iterator[None]:
        """Wait for the imaging node with one thread at a time."""
        if not self._working.acquire(blocking=False):
            raise BusyError(AT_WORK)
        try:
            yield
        finally:
            self._working.release()


def folder_of(data: Path, name: str) -> Path:
    """Return the folder of a survey, in which no file is a link.

    Raises:
        Gpr20Error: There is none, or the name is not that of one.
    """
    if survey_folder.FOLDER_NAME.fullmatch(name):
        for folder in survey_folder.candidate_folders(data, name):
            survey_folder.check_no_links(folder)
            return folder
    raise no_survey(name)


def size_of(folder: Path) -> int:
    """Return the size of a survey [bytes] that nobody writes: half of one looks whole.

    Raises:
        Gpr20Error: Somebody writes it, or it cannot be read.
    """
    with storing(UNREADABLE, folder):
        if writer_of(folder) is not None:
            raise NotNowError(
                Message("the survey is being written; it can be downloaded when it has ended")
            )
        return sum((folder / one).lstat().st_size for one in regular_files(folder))


class _Collected(bytearray):
    """Takes what a ZIP file writes; without `tell` and `seek` it writes in one pass."""

    def write(self, data: bytes) -> int:
        self += data
        return len(data)

    def flush(self) -> None:
        """Do nothing: everything is here."""


def zip_parts(folder: Path) -> Iterator[bytes]:
    """Yield a ZIP file of a folder as it is made, stored without compression.

    Raises:
        ProcessingError: See `add_folder`; what was yielded so far is no ZIP file.
    """
    parts: Any = _Collected()
    with zipfile.ZipFile(parts, "w", zipfile.ZIP_STORED) as archive:
        for _ in add_folder(archive, folder):
            if len(parts) >= PIECE_BYTES:
                yield bytes(parts)
                parts.clear()
    yield bytes(parts)
