"""The storage's topics and services, and plan and coverage of a survey, as events."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable, List, Mapping, Optional, Tuple

import rospy
from std_msgs.msg import String

from gpr20_common.high.raw_message import connection_header
from gpr20_common.high.service_client import ServiceClient
from gpr20_msgs.msg import SurveyCoverage
from gpr20_msgs.srv import AddFact, ListSurveys, ReadSurvey, ReadTraces
from gpr20_operator.ground.additions import AdditionsFailed, MarkersStored, MarkingFailed
from gpr20_operator.ground.traces import (
    ReadingFailed,
    SurveyDescribed,
    SurveyRead,
    TraceEvent,
)
from gpr20_operator.high import conversions
from gpr20_operator.high.ros_events import (
    STORAGE_SILENT,
    RosEvents,
    WhileWatched,
    accepted,
    call,
)
from gpr20_operator.robot.events import Senders
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.markers import Marker, present_markers
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

READ_TIMEOUT_S = 20.0
# Another request, such as closing a large survey, may come first.
CHANGE_TIMEOUT_S = 60.0
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
        self._facts = ServiceClient("add_fact", AddFact)
        self._traced = WhileWatched(self._trace_subscriptions)

    def listen(self) -> None:
        """Subscribe to plan and coverage."""
        self._subscribe("survey_metadata", String, lambda one: SurveyDescribed(one.data), 1)
        self._subscribe("survey_coverage", SurveyCoverage, conversions.coverage_runs, 1)

    def close(self) -> None:
        """Call the listener no more."""
        self.set_watched(False)
        super().close()

    def set_watched(self, watched: bool) -> None:
        """Follow traces, or no longer: the storage has those that were missed."""
        self._traced.set_watched(watched)

    def _trace_subscriptions(self) -> List[rospy.Subscriber]:
        # As it was sent: the converter of traces reads these bytes.
        return [self._subscriber("trace", rospy.AnyMsg, _trace, TRACE_QUEUE)]

    def list_surveys(self, before: str) -> None:
        """Ask for the surveys older than a folder; empty: for the newest."""
        self._emit_answer(
            lambda: conversions.surveys_listed(before, self._listed(before)), ReadingFailed
        )

    def read_survey(self, folder: str) -> None:
        """Ask for the plan of a past survey."""

        def ask() -> SurveyRead:
            answer = self._read(folder)
            return SurveyRead(folder, answer.metadata_json, tuple(answer.stored_indices))

        self._emit_answer(ask, ReadingFailed)

    def read_traces(self, survey: str, indices: Tuple[int, ...]) -> None:
        """Ask for stored traces of a survey, by its id and their places in the plan."""

        def ask() -> TraceEvent:
            answer = _answer(self._traces, READ_TIMEOUT_S, survey=survey, indices=indices)
            return conversions.traces_read(indices[0], answer)

        self._emit_answer(ask, ReadingFailed)

    def read_additions(self, survey: str) -> None:
        """Ask for the markers of a survey, by its id."""

        def ask() -> MarkersStored:
            text = self._read(survey).metadata_json
            description = parse_object(text, "metadata_json", MAX_FILE_BYTES)
            return MarkersStored(survey, present_markers(description))

        self._emit_answer(ask, partial(AdditionsFailed, survey))

    def add_marker(self, survey: str, marker: Marker) -> None:
        """Ask to store a marker of a survey, by its id."""
        self._change_markers(survey, Kind.MARKER, marker.request())

    def remove_marker(self, survey: str, marker_id: str, author: str) -> None:
        """Ask to remove a marker of a survey, by its id."""
        values = {"marker_id": marker_id, "author": author}
        self._change_markers(survey, Kind.MARKER_REMOVED, values)

    def _change_markers(self, survey: str, kind: Kind, values: Mapping[str, Any]) -> None:
        def ask() -> MarkersStored:
            fields = conversions.fact_fields(survey, kind, values)
            return conversions.markers_stored(_answer(self._facts, CHANGE_TIMEOUT_S, **fields))

        self._emit_answer(ask, partial(MarkingFailed, survey, values["marker_id"]))

    def _listed(self, before: str) -> Any:
        return _answer(self._list, READ_TIMEOUT_S, before=before, max_surveys=SURVEYS_PER_PAGE)

    def _read(self, survey: str) -> Any:
        return _answer(self._survey, READ_TIMEOUT_S, survey=survey)


def _trace(message: rospy.AnyMsg) -> Optional[Trace]:
    try:
        return trace_message.decode(message._buff, connection_header(message)["md5sum"])
    except TraceRefusedError as error:
        rospy.logwarn("not shown: %s", error)
        return None


def _answer(client: ServiceClient, timeout_s: float, **fields: Any) -> Any:
    return accepted(call(client, STORAGE_SILENT, timeout_s, **fields))
