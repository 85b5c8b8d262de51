"""Markers and related surveys, asked of the storage without waiting."""

from __future__ import annotations

import json
from typing import Any, Callable, List

from gpr20_common.errors import InvalidValueError
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_common.sent_message import message_from
from gpr20_msgs.srv import ListSurveys, MarkSurvey, ReadSurvey
from gpr20_operator import faults
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.additions import (
    AdditionsFailed,
    AdditionsRead,
    MarkersStored,
    MarkingFailed,
    RelatedSurvey,
)
from gpr20_operator.ground.geometry import Area
from gpr20_operator.ground.grid import grid_from_description
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.markers import Marker, present_markers
from gpr20_survey.plan.refines import refines_of
from gpr20_user_interface.high.ros_events import in_background

READ_TIMEOUT_S = 20.0
# Another request, such as closing a large survey, may come first.
MARK_TIMEOUT_S = 60.0
# A finer survey follows the one that it refines: it is searched for among the newest ones.
SURVEYS_SEARCHED = 50


class _RequestError(Exception):
    """The storage has not answered, or has refused."""

    def __init__(self, reason: Message) -> None:
        super().__init__(str(reason))
        self.reason = reason


class AdditionsClient:
    """Asks the storage in the background and passes the answers to a listener.

    Args:
        emit: Called with each event, from any thread.
    """

    def __init__(self, emit: Callable[[Any], None]) -> None:
        self._emit = emit
        self._list = ServiceClient("list_surveys", ListSurveys)
        self._survey = ServiceClient("read_survey", ReadSurvey)
        self._mark = ServiceClient("mark_survey", MarkSurvey)

    def read_additions(self, survey: str) -> None:
        """Ask for markers and related surveys of a survey, by its id."""
        in_background(lambda: self._emit(self._read(survey)))

    def add_marker(self, survey: str, marker: Marker) -> None:
        """Ask to store a marker of a survey, by its id."""
        depth_mm = marker.depth_mm
        request = {
            "marker_id": marker.marker_id,
            "x_mm": marker.x_mm,
            "y_mm": marker.y_mm,
            "has_depth": depth_mm is not None,
            "depth_mm": 0.0 if depth_mm is None else depth_mm,
            "text": marker.text,
            "author": marker.author,
        }
        in_background(lambda: self._emit(self._change(survey, request)))

    def remove_marker(self, survey: str, marker_id: str, author: str) -> None:
        """Ask to remove a marker of a survey, by its id."""
        request = {"marker_id": marker_id, "remove": True, "author": author}
        in_background(lambda: self._emit(self._change(survey, request)))

    def _change(self, survey: str, request: Any) -> Any:
        try:
            answer = _answer(lambda: self._mark.call(MARK_TIMEOUT_S, survey=survey, **request))
            description = {"markers": json.loads(answer.markers_json)}
            return MarkersStored(answer.survey_id, present_markers(description))
        except (_RequestError, InvalidValueError) as error:
            return MarkingFailed(survey, request["marker_id"], _reason(error))

    def _read(self, survey: str) -> Any:
        try:
            description = self._description(survey)
            markers = present_markers(description)
            return AdditionsRead(survey, markers, tuple(self._related(survey, description)))
        except (_RequestError, InvalidValueError, SurveyRefusedError) as error:
            return AdditionsFailed(survey, _reason(error))

    def _related(self, survey: str, description: Any) -> List[RelatedSurvey]:
        listed = _answer(
            lambda: self._list.call(READ_TIMEOUT_S, before="", max_surveys=SURVEYS_SEARCHED)
        )
        found = []
        coarse = refines_of(description)
        for one in listed.surveys:
            is_finer = one.refines == survey
            if one.survey_id != survey and (is_finer or one.survey_id == coarse):
                found += self._area(one.survey_id, one.folder, is_finer)
        if coarse and coarse not in {one.survey_id for one in found}:
            found += self._area(coarse, "", False)
        return found

    def _area(self, survey: str, folder: str, is_finer: bool) -> List[RelatedSurvey]:
        """Return a related survey; none if it is no longer there or cannot be read."""
        try:
            text = self._description_text(survey)
            grid = grid_from_description(text)
        except (_RequestError, SurveyNotReadableError):
            return []
        xs_mm, ys_mm = grid.xs_mm, grid.ys_mm
        area = Area(float(xs_mm.min()), float(xs_mm.max()), float(ys_mm.min()), float(ys_mm.max()))
        return [RelatedSurvey(survey, folder or survey, is_finer, area)]

    def _description(self, survey: str) -> Any:
        return parse_object(self._description_text(survey), "survey.json", MAX_FILE_BYTES)

    def _description_text(self, survey: str) -> str:
        answer = _answer(lambda: self._survey.call(READ_TIMEOUT_S, survey=survey))
        return str(answer.metadata_json)


def _answer(call: Callable[[], Any]) -> Any:
    try:
        response = call()
    except ServiceUnavailableError as error:
        raise _RequestError(
            Message(
                "the storage does not answer; check that it is running", details=error
            ).with_fault(faults.PART_SILENT)
        ) from error
    if not response.success:
        raise _RequestError(message_from(response))
    return response


def _reason(error: Any) -> Message:
    return error.reason if isinstance(error, _RequestError) else error.message
