"""The services that change the annotation of a survey, and add a fact to its log."""

from __future__ import annotations

from typing import Any

from gpr20_common.high.services import advertise
from gpr20_common.message import Message
from gpr20_common.sent_message import message_fields
from gpr20_msgs.srv import (
    AnnotateSurvey,
    AnnotateSurveyResponse,
    NoteSurvey,
    NoteSurveyResponse,
)
from gpr20_survey.plan import annotation
from gpr20_vna_processing.mid.data_processing import DataProcessing


class AnnotationService:
    """Turns requests into calls of DataProcessing."""

    def __init__(self, processing: DataProcessing) -> None:
        self._processing = processing
        self._services = [
            advertise("annotate_survey", AnnotateSurvey, self._annotate),
            advertise("note_survey", NoteSurvey, self._note),
        ]

    def _annotate(self, request: Any) -> AnnotateSurveyResponse:
        wanted = annotation.from_fields(request.annotation)
        annotated = self._processing.annotate(request.survey, wanted)
        message = Message("the annotation of survey {survey} is stored", survey=annotated.survey_id)
        return AnnotateSurveyResponse(
            success=True,
            **message_fields(message),
            path=str(annotated.folder),
            survey_id=annotated.survey_id,
        )

    def _note(self, request: Any) -> NoteSurveyResponse:
        noted = self._processing.note(request.survey, request.kind, request.values_json)
        message = Message("the note on survey {survey} is stored", survey=noted.survey_id)
        return NoteSurveyResponse(
            success=True,
            **message_fields(message),
            path=str(noted.folder),
            survey_id=noted.survey_id,
        )
