"""Traces and surveys on the ROS graph, for objects that live in the thread of a window."""

from __future__ import annotations

from typing import Any, Callable

from PyQt5.QtCore import QObject, pyqtSignal
from std_msgs.msg import String

from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_msgs.msg import SurveyCoverage, Trace
from gpr20_msgs.srv import ListSurveys, ReadSurvey, ReadTraces
from gpr20_user_interface.high import trace_conversions as conversions
from gpr20_user_interface.high.ros_events import RosEvents, in_background
from gpr20_user_interface.mid.trace_events import ReadingFailed, TraceEvent

LIST_TIMEOUT_S = 20.0
READ_TIMEOUT_S = 20.0
SURVEYS_PER_PAGE = 20
# A page is converted at once in the window's process and must not make it stutter.
TRACES_PER_PAGE = 50
# Beyond this a window that is too slow loses traces; it reads them again from the storage.
TRACE_QUEUE = 200


class StorageClient(QObject):
    """Emits what is said of traces as signals; asks the storage without waiting."""

    event = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self._list = ServiceClient("list_surveys", ListSurveys)
        self._survey = ServiceClient("read_survey", ReadSurvey)
        self._traces = ServiceClient("read_traces", ReadTraces)
        self._listening = RosEvents(self._emit)

    def listen(self) -> None:
        """Begin to emit events."""
        self._listening.subscribe("survey_metadata", String, conversions.survey_described, 1)
        self._listening.subscribe("survey_coverage", SurveyCoverage, conversions.coverage_runs, 1)
        self._listening.subscribe("trace", Trace, conversions.radar_trace, TRACE_QUEUE)

    def close(self) -> None:
        """Emit nothing more, whatever is still on its way."""
        self._listening.close()

    def list_surveys(self, before: str) -> None:
        """Ask for the surveys older than a folder; empty: for the newest."""
        self._ask(
            lambda: self._list.call(LIST_TIMEOUT_S, before=before, max_surveys=SURVEYS_PER_PAGE),
            lambda response: conversions.surveys_listed(before, response),
        )

    def read_survey(self, folder: str) -> None:
        """Ask what a past survey was to measure."""
        self._ask(
            lambda: self._survey.call(READ_TIMEOUT_S, survey=folder),
            lambda response: conversions.survey_read(folder, response),
        )

    def read_traces(self, survey: str, first_index: int) -> None:
        """Ask for a page of stored traces of a survey, by its id."""
        self._ask(
            lambda: self._traces.call(
                READ_TIMEOUT_S,
                survey=survey,
                first_index=first_index,
                max_traces=TRACES_PER_PAGE,
            ),
            lambda response: conversions.traces_read(first_index, response),
        )

    def _ask(self, call: Callable[[], Any], convert: Callable[[Any], TraceEvent]) -> None:
        in_background(lambda: self._answer(call, convert))

    def _answer(self, call: Callable[[], Any], convert: Callable[[Any], TraceEvent]) -> None:
        try:
            response = call()
        except ServiceUnavailableError as error:
            self._listening.tell(ReadingFailed(str(error)))
            return
        self._listening.tell(
            convert(response) if response.success else ReadingFailed(response.message)
        )

    # A method, not the signal's own emit: a signal does not keep its object alive, and threads
    # of ROS may outlive everybody else who does; after the end even the object itself.
    def _emit(self, event: TraceEvent) -> None:
        self.event.emit(event)
