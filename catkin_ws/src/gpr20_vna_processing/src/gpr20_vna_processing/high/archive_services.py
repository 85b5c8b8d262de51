"""The services that read surveys back."""

from __future__ import annotations

import dataclasses
import json
from typing import Any, List

import rospy

from gpr20_common.high.raw_message import deserialized
from gpr20_common.high.services import advertise
from gpr20_msgs.msg import SurveySummary, Trace
from gpr20_msgs.srv import (
    ListSurveys,
    ListSurveysResponse,
    ReadSurvey,
    ReadSurveyResponse,
    ReadTraces,
    ReadTracesResponse,
)
from gpr20_survey.trace import trace_message
from gpr20_vna_processing.mid.survey_archive import SurveyArchive


class ArchiveServices:
    """Turns requests into calls of a SurveyArchive and its answers into messages."""

    def __init__(self, archive: SurveyArchive) -> None:
        self._archive = archive
        self._services: List[rospy.Service] = [
            advertise("list_surveys", ListSurveys, self._list),
            advertise("read_survey", ReadSurvey, self._survey),
            advertise("read_traces", ReadTraces, self._traces),
        ]

    def _list(self, request: Any) -> ListSurveysResponse:
        surveys, more = self._archive.list(request.before, request.max_surveys)
        messages = [SurveySummary(**dataclasses.asdict(one)) for one in surveys]
        return ListSurveysResponse(True, f"{len(messages)} surveys", messages, more)

    def _survey(self, request: Any) -> ReadSurveyResponse:
        survey = self._archive.survey(request.survey)
        return ReadSurveyResponse(
            success=True,
            message=f"{len(survey.stored_indices)} traces are stored",
            survey_id=survey.survey_id,
            metadata_json=json.dumps(survey.description),
            stored_indices=survey.stored_indices,
        )

    def _traces(self, request: Any) -> ReadTracesResponse:
        page = self._archive.traces(request.survey, request.first_index, request.max_traces)
        return ReadTracesResponse(
            success=True,
            message=f"{len(page.traces)} traces, {len(page.unreadable)} files cannot be read",
            survey_id=page.survey_id,
            traces=[deserialized(Trace, trace_message.encode(trace)) for trace in page.traces],
            unreadable=[f"{index}: {reason}" for index, reason in page.unreadable],
            next_index=page.next_index,
            more=page.more,
        )
