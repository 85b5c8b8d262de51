"""The services that read surveys back."""

from __future__ import annotations

import json
from typing import Any, List

import rospy

from gpr20_common.high.services import advertise, success
from gpr20_common.message import Message
from gpr20_msgs.msg import SurveySummary
from gpr20_msgs.srv import (
    ListSurveys,
    ReadSurvey,
    ReadTraces,
)
from gpr20_survey.results.survey_summary import summary_fields
from gpr20_survey.trace.trace_block import block_fields
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

    def _list(self, request: Any) -> Any:
        surveys, more = self._archive.list(request.before, request.max_surveys)
        return success(
            ListSurveys,
            Message("{count} surveys", count=len(surveys)),
            surveys=[SurveySummary(**summary_fields(one, SurveySummary)) for one in surveys],
            more=more,
        )

    def _survey(self, request: Any) -> Any:
        survey = self._archive.survey(request.survey)
        return success(
            ReadSurvey,
            Message("{count} traces stored", count=len(survey.stored_indices)),
            survey_id=survey.survey_id,
            metadata_json=json.dumps(survey.description),
            stored_indices=survey.stored_indices,
        )

    def _traces(self, request: Any) -> Any:
        block, unreadable = self._archive.traces(request.survey, request.indices)
        message = Message(
            "{count} traces, {unreadable} files cannot be read",
            count=len(block.indices),
            unreadable=len(unreadable),
        )
        return success(
            ReadTraces,
            message,
            **block_fields(block),
            unreadable=[f"{index}: {reason}" for index, reason in unreadable.items()],
            unreadable_json=[reason.to_json() for reason in unreadable.values()],
        )
