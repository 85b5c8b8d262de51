"""The service that adds and removes markers of a survey."""

from __future__ import annotations

import json
from typing import Any

from gpr20_common.high.services import advertise
from gpr20_common.message import Message
from gpr20_common.sent_message import message_fields
from gpr20_msgs.srv import MarkSurvey, MarkSurveyResponse
from gpr20_survey.plan.annotation import MAX_NAME_CHARACTERS, OPERATOR, check_text
from gpr20_survey.plan.markers import Marker, values_of
from gpr20_vna_processing.mid.data_processing import DataProcessing


class MarkerService:
    """Turns requests into calls of DataProcessing."""

    def __init__(self, processing: DataProcessing) -> None:
        self._processing = processing
        self._service = advertise("mark_survey", MarkSurvey, self._mark)

    def _mark(self, request: Any) -> MarkSurveyResponse:
        if request.remove:
            check_text(OPERATOR, request.author, MAX_NAME_CHARACTERS)
            marked = self._processing.remove_marker(
                request.survey, request.marker_id, request.author
            )
            message = Message("the marker is removed from survey {survey}", survey=marked.survey_id)
        else:
            marked = self._processing.add_marker(request.survey, _marker_of(request))
            message = Message("the marker of survey {survey} is stored", survey=marked.survey_id)
        return MarkSurveyResponse(
            success=True,
            **message_fields(message),
            path=str(marked.folder),
            survey_id=marked.survey_id,
            markers_json=json.dumps(values_of(marked.markers)),
        )


def _marker_of(request: Any) -> Marker:
    return Marker(
        marker_id=request.marker_id,
        x_mm=request.x_mm,
        y_mm=request.y_mm,
        depth_mm=request.depth_mm if request.has_depth else None,
        text=request.text,
        author=request.author,
    )
