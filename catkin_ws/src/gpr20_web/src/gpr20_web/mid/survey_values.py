"""A stored survey as a browser sees it, in the sentences of the window."""

from __future__ import annotations

import time
from typing import Any, Callable, Dict, Optional

from gpr20_common.errors import Gpr20Error
from gpr20_operator.ground.past_surveys import Ending, PastSurveys
from gpr20_operator.jobs import result_texts as texts
from gpr20_operator.jobs.job import Service, Ticket
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey
from gpr20_operator.jobs.result import SurveyResult, list_sum
from gpr20_operator.plan.fields import PEOPLE
from gpr20_operator.plan.form import annotation_texts
from gpr20_operator.words import local_time
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.results.answers import SurveySummary
from gpr20_survey.results.candidates import NO_CLEARANCE, SIMULATED, Candidate
from gpr20_web.calls import Text, sentence

Ask = Callable[..., Any]
"""Asks a Service with these fields, and returns its answer or raises Gpr20Error."""


class OpenedSurvey:
    """A survey that was read, and its answer, while the caller waits.

    Args:
        ask: Asks storage and imaging node.
        folder: That of the survey.
        focus: How an image is asked for, besides what the survey says.

    Attributes:
        result: As in the window; what is lacking has its reason in its jobs.
        stored: What the storage has; None: it cannot be read.
    """

    def __init__(self, ask: Ask, folder: str, **focus: Any) -> None:
        self._ask, self._focus = ask, focus
        self.stored: Optional[StoredSurvey] = None
        self.result = SurveyResult(Imaging(self, time.monotonic))
        self.result.open(folder)
        for _step in ("read", "focus"):
            self.result.keep()

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        """Call a service, and let the ticket take the answer."""
        more = self._focus if service is Service.FOCUS else {}
        try:
            found = self._ask(service, **fields, **more)
        except Gpr20Error as error:
            ticket.fail(error.message)
            return
        if service is Service.READ:
            self.stored = found
        ticket.done(found)

    def cancel(self, request_id: str) -> None:
        """Do nothing: whoever asks has waited for the answer."""


def row_of(past: PastSurveys, survey: SurveySummary, text: Text) -> Dict[str, Any]:
    """Return a row of the list."""
    ending = past.ending_of(survey)
    return {
        "folder": survey.folder,
        "title": text(past.title_of(survey)),
        "time": text(local_time(survey.started, survey.folder)),
        "ending": sentence(text, past.ending(survey)),
        "state": ending.value,
        "simulated": survey.simulated and ending is not Ending.UNREADABLE,
        "people": " · ".join(one for one in (survey.site, survey.operator) if one),
    }


def written_of(stored: Optional[StoredSurvey], text: Text) -> Dict[str, Any]:
    """Return what people have written about a survey.

    Raises:
        Gpr20Error: It is damaged.
    """
    values = {} if stored is None else parse_object(stored.text, "metadata_json", MAX_FILE_BYTES)
    notes = annotation_texts(annotation_of(values))
    return {"notes": [(text(one.title), notes[one.name]) for one in PEOPLE if notes[one.name]]}


def result_of(result: SurveyResult, text: Text) -> Dict[str, Any]:
    """Return what was found in a survey, and its candidates if they are known."""
    record, image = result.record, result.image
    found = () if record is None else record.found
    shown: Dict[str, Any] = {"found": [sentence(text, texts.found_line(one)) for one in found]}
    if image is None:
        return shown
    places, soil = result.places, ": ".join(map(text, texts.soil_lines(result)))
    warnings = [
        *([SIMULATED] if image.found.simulated else []),
        NO_CLEARANCE,
        *texts.doubts(result),
        *([] if places else [texts.NOT_SAFE]),
    ]
    notes = [text(one) for one in (*texts.notices(result), texts.FROM_MARK)]
    shown["candidates"] = {
        "headline": sentence(text, texts.headline(image.found)),
        "warnings": [text(one) for one in warnings],
        "notes": [*notes, soil],
        "list": list_sum(image.found),
        "weaker": sentence(text, texts.weaker_line(image.found)),
        "places": [_place(result, one, text) for one in places],
    }
    return shown


def _place(result: SurveyResult, place: Candidate, text: Text) -> Dict[str, Any]:
    found = result.find_at(place)
    return {
        "id": place.id,
        "number": place.number,
        "place": text(texts.place_line(place)),
        "doubtful": place.is_doubtful,
        "line": sentence(text, texts.why_line(place)),
        "why": [sentence(text, one) for one in texts.why_lines(place)],
        "found": "" if found is None else sentence(text, texts.found_line(found)),
    }
