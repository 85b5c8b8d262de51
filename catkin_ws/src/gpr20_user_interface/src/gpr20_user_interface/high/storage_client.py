"""The storage's topics and services, and plan and coverage of a survey, as events."""

from __future__ import annotations

from typing import Any, Callable, Tuple

import rospy
from std_msgs.msg import String

from gpr20_common.high.connection_header import connection_header
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import SurveyCoverage
from gpr20_msgs.srv import AnnotateSurvey, ListSurveys, ReadSurvey, ReadTraces
from gpr20_operator import faults
from gpr20_operator.ground.trace_events import (
    AnnotationFailed,
    AnnotationStored,
    ReadingFailed,
    TraceEvent,
)
from gpr20_operator.robot.senders import Senders
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.trace import trace_message
from gpr20_user_interface.high import conversions
from gpr20_user_interface.high.additions_client import AdditionsClient
from gpr20_user_interface.high.ros_events import RosEvents, in_background

LIST_TIMEOUT_S = 20.0
READ_TIMEOUT_S = 20.0
# Another request, such as closing a large survey, may come first.
ANNOTATE_TIMEOUT_S = 60.0
SURVEYS_PER_PAGE = 50
# A window that is slower loses traces; it reads them from the storage later.
TRACE_QUEUE = 200


class StorageClient(RosEvents):
    """Passes everything about traces to a listener; asks the storage without waiting."""

    def __init__(self, listener: Callable[[TraceEvent], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._list = ServiceClient("list_surveys", ListSurveys)
        self._survey = ServiceClient("read_survey", ReadSurvey)
        self._traces = ServiceClient("read_traces", ReadTraces)
        self._annotate = ServiceClient("annotate_survey", AnnotateSurvey)
        self._additions = AdditionsClient(self._emit)
        self.read_additions = self._additions.read_additions
        self.add_marker = self._additions.add_marker
        self.remove_marker = self._additions.remove_marker

    def listen(self) -> None:
        """Subscribe to plan, coverage and traces."""
        self._subscribe("survey_metadata", String, conversions.survey_described, 1)
        self._subscribe("survey_coverage", SurveyCoverage, conversions.coverage_runs, 1)
        # As it was sent: the converter of traces reads these bytes.
        self._subscribe_raw("trace", rospy.AnyMsg, self._on_trace, TRACE_QUEUE)

    def list_surveys(self, before: str) -> None:
        """Ask for the surveys older than a folder; empty: for the newest."""
        self._ask(
            lambda: self._list.call(LIST_TIMEOUT_S, before=before, max_surveys=SURVEYS_PER_PAGE),
            lambda response: conversions.surveys_listed(before, response),
        )

    def read_survey(self, folder: str) -> None:
        """Ask for the plan of a past survey."""
        self._ask(
            lambda: self._survey.call(READ_TIMEOUT_S, survey=folder),
            lambda response: conversions.survey_read(folder, response),
        )

    def read_traces(self, survey: str, indices: Tuple[int, ...]) -> None:
        """Ask for stored traces of a survey, by its id and their places in the plan."""
        self._ask(
            lambda: self._traces.call(READ_TIMEOUT_S, survey=survey, indices=indices),
            lambda response: conversions.traces_read(indices[0], response),
        )

    def read_annotation(self, survey: str) -> None:
        """Ask for the annotation of a survey, by its id or folder."""
        self._ask(
            lambda: self._survey.call(READ_TIMEOUT_S, survey=survey),
            lambda response: conversions.annotation_read(survey, response),
            AnnotationFailed,
        )

    def annotate(self, survey: str, annotation: Annotation) -> None:
        """Ask to replace the annotation of a survey, by its id or folder."""
        note = conversions.annotation_message(annotation)
        self._ask(
            lambda: self._annotate.call(ANNOTATE_TIMEOUT_S, survey=survey, annotation=note),
            lambda _response: AnnotationStored(survey),
            AnnotationFailed,
        )

    def _on_trace(self, message: rospy.AnyMsg) -> None:
        try:
            trace = trace_message.decode(message._buff, connection_header(message)["md5sum"])
        except TraceRefusedError as error:
            rospy.logwarn("not shown: %s", error)
        else:
            self._emit(trace)

    def _ask(
        self,
        call: Callable[[], Any],
        convert: Callable[[Any], TraceEvent],
        failed: Callable[[Message], TraceEvent] = ReadingFailed,
    ) -> None:
        in_background(lambda: self._emit(self._answer(call, convert, failed)))

    @staticmethod
    def _answer(
        call: Callable[[], Any],
        convert: Callable[[Any], TraceEvent],
        failed: Callable[[Message], TraceEvent],
    ) -> TraceEvent:
        try:
            response = call()
        except ServiceUnavailableError as error:
            return failed(
                Message(
                    "the storage does not answer; check that it is running", details=error
                ).with_fault(faults.PART_SILENT)
            )
        return convert(response) if response.success else failed(message_from(response))
