"""The storage and what works beside it: its topics as events, and requests without waiting."""

from __future__ import annotations

import itertools
import json
import os
from functools import partial
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence

import rospy
from std_msgs.msg import String

from gpr20_common.errors import Gpr20Error
from gpr20_common.high.answers import fault_of, message_from, received, record_of
from gpr20_common.high.raw_message import connection_header
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_doctor.high.graph import analyzer_test_of
from gpr20_doctor.mid.findings import examine
from gpr20_doctor.mid.machine import Machine
from gpr20_msgs import srv
from gpr20_msgs.msg import Fault, ImagingProgress, SurveyCoverage
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.high.ros_events import (
    CONTROL_SILENT,
    STORAGE_SILENT,
    RequestError,
    RosEvents,
    accepted,
    in_background,
    no_answer,
)
from gpr20_operator.jobs.job import Delivery, Service, Ticket
from gpr20_operator.jobs.pictures import (
    Exported,
    Sticks,
    StoredSurvey,
    SurveysListed,
    TracesRead,
)
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.service_model import HeightTested
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.answers import SurveySummary, Volume, image_from
from gpr20_survey.results.hiding_map import hiding_from
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace, block_from

IMAGING_SILENT = Message(
    "the imaging node does not answer; check that it is running on the computer of the storage"
)
HEIGHT_SILENT = Message("the height sensor does not answer; check that it is running")
# Longer than the node's own limits; other requests may come first.
LONG_TIMEOUT_S = 4 * 3600.0
SHORT_TIMEOUT_S = 20.0
# Another request, such as closing a large survey, may come first.
FACT_TIMEOUT_S = 60.0
# At the lowest speed an axis of 800 mm takes 800 s to its endstop. The motion can be stopped
# meanwhile, and goes to its end whether this client waits or not.
MOVE_TIMEOUT_S = 1200.0
HEIGHT_TIMEOUT_S = 10.0
# Several requests to the VNA, of which each has its own limit in the main control.
ANALYZER_TIMEOUT_S = 300.0
NO_ROBOT = Message("a replay is shown, and no robot")
# A window that is slower loses traces; it reads them from the storage later.
TRACE_QUEUE = 200


class _Offer(NamedTuple):
    """A service: its class, its time limit [s], who offers it, and what its answer becomes."""

    kind: Any
    timeout_s: float
    silent: Message
    convert: Callable[[Any], Any]


def _height_tested(response: Any) -> HeightTested:
    failure = None if response.success else message_from(response)
    return record_of(HeightTested, response, failure=failure)


def _said(response: Any) -> Message:
    return message_from(accepted(response))


OFFERS: Dict[Service, _Offer] = {
    Service.FOCUS: _Offer(
        *(srv.FocusSurvey, LONG_TIMEOUT_S, IMAGING_SILENT), lambda one: image_from(accepted(one))
    ),
    Service.HIDE: _Offer(
        *(srv.MapHidden, LONG_TIMEOUT_S, IMAGING_SILENT),
        lambda one: hiding_from(accepted(one).hiding_json),
    ),
    Service.EXPORT: _Offer(
        *(srv.ExportSurvey, LONG_TIMEOUT_S, IMAGING_SILENT),
        lambda one: Exported(tuple(accepted(one).files), one.content),
    ),
    Service.STICKS: _Offer(
        *(srv.ListVolumes, SHORT_TIMEOUT_S, IMAGING_SILENT),
        lambda one: Sticks(
            accepted(one).computer, tuple(record_of(Volume, each) for each in one.volumes)
        ),
    ),
    Service.READ: _Offer(
        *(srv.ReadSurvey, SHORT_TIMEOUT_S, STORAGE_SILENT),
        lambda one: StoredSurvey(accepted(one).metadata_json, tuple(one.stored_indices)),
    ),
    Service.LIST: _Offer(
        *(srv.ListSurveys, SHORT_TIMEOUT_S, STORAGE_SILENT),
        lambda one: SurveysListed(
            tuple(record_of(SurveySummary, each) for each in accepted(one).surveys), one.more
        ),
    ),
    Service.TRACES: _Offer(
        *(srv.ReadTraces, SHORT_TIMEOUT_S, STORAGE_SILENT),
        lambda one: TracesRead(
            block_from(accepted(one)), _reasons(one.unreadable, one.unreadable_faults)
        ),
    ),
    Service.FACT: _Offer(srv.AddFact, FACT_TIMEOUT_S, STORAGE_SILENT, _said),
    Service.MOVE: _Offer(srv.ServiceMove, MOVE_TIMEOUT_S, CONTROL_SILENT, _said),
    # A test that failed says what it has found before.
    Service.HEIGHT: _Offer(srv.GetHeight, HEIGHT_TIMEOUT_S, HEIGHT_SILENT, _height_tested),
    Service.ANALYZER: _Offer(
        srv.TestAnalyzer, ANALYZER_TIMEOUT_S, CONTROL_SILENT, analyzer_test_of
    ),
    Service.DAILY: _Offer(srv.DailyCheck, ANALYZER_TIMEOUT_S, CONTROL_SILENT, _said),
}


class StorageClient(RosEvents):
    """Passes everything about traces to a listener, and what comes of jobs; see `Requests`."""

    def __init__(self, listener: Callable[[Any], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._clients = {one: ServiceClient(one.value, offer.kind) for one, offer in OFFERS.items()}
        self._cancel = ServiceClient("cancel_imaging", srv.CancelImaging)
        # The export alone reports its progress.
        self._exporting: Optional[Ticket[Any]] = None

    def listen(self) -> None:
        """Subscribe to plan, coverage and the progress of jobs."""
        self._subscribe("survey_metadata", String, lambda one: SurveyDescribed(one.data), 1)
        self._subscribe("survey_coverage", SurveyCoverage, coverage_runs, 1)
        self._subscribe("imaging_progress", ImagingProgress, self._on_progress, 20)

    def _watched_topics(self) -> List[rospy.Subscriber]:
        # As it was sent: the converter of traces reads these bytes. The storage has those that
        # were missed.
        return [self._subscriber("trace", rospy.AnyMsg, _trace, TRACE_QUEUE)]

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        """Call a service in the background, and let the ticket take the answer."""
        if self._senders.replay:
            self._emit(Delivery(partial(ticket.fail, NO_ROBOT)))
            return
        if service.can_be_cancelled:
            fields["request_id"] = ticket.request_id
        if service is Service.EXPORT:
            self._exporting = ticket

        def work() -> None:
            try:
                answer = partial(ticket.done, self.wait_for(service, **fields))
            except (RequestError, Gpr20Error) as error:
                answer = partial(ticket.fail, error.message)
            self._emit(Delivery(answer))

        in_background(work)

    def wait_for(self, service: Service, **fields: Any) -> Any:
        """Call a service in this thread, and return what its answer becomes.

        Raises:
            RequestError: Its node does not answer, or refuses.
            Gpr20Error: The answer is not as it should be.
        """
        if service is Service.FACT:
            values_json = json.dumps(fields.pop("values"), allow_nan=False)
            fields = {**fields, "kind": fields["kind"].value, "values_json": values_json}
        offer = OFFERS[service]
        try:
            found = self._clients[service].call(offer.timeout_s, **fields)
        except ServiceUnavailableError as error:
            raise RequestError(no_answer(offer.silent, error)) from error
        return offer.convert(found)

    def examine(self, nodes: Mapping[str, NodeDescription], thorough: bool) -> None:
        """Look at this computer in the background; its MachineReport is an event."""

        def look() -> None:
            machine = Machine.here(os.environ, nodes=nodes, thorough=thorough)
            self._emit(examine(machine))

        in_background(look)

    def cancel(self, request_id: str) -> None:
        """Ask to end a request of a job."""

        def work() -> None:
            try:
                self._cancel.call(SHORT_TIMEOUT_S, request_id=request_id)
            except ServiceUnavailableError as error:
                # The job takes no answer any more; without a node there is nothing to end.
                rospy.loginfo("not cancelled: %s", error)

        in_background(work)

    def _on_progress(self, message: ImagingProgress) -> Optional[Delivery]:
        ticket = self._exporting
        if ticket is None or message.request_id != ticket.request_id:
            return None
        return Delivery(partial(ticket.progress, message_from(message)))


def coverage_runs(message: SurveyCoverage) -> CoverageRuns:
    """Convert `survey_coverage`."""
    return record_of(
        CoverageRuns,
        message,
        starts=tuple(message.run_starts),
        states=tuple(bytearray(message.run_states)),
        failures=_reasons(message.failures, message.failure_faults),
    )


def _reasons(texts: Sequence[str], faults_of: Sequence[Fault]) -> Dict[int, Message]:
    """Return the reasons of traces by their index, from lines "index: reason"."""
    found = {}
    for line, fault in itertools.zip_longest(texts, faults_of[: len(texts)]):
        index, _separator, text = line.partition(": ")
        if index.isdigit():
            found[int(index)] = received(text, fault or fault_of(None))
    return found


def _trace(message: rospy.AnyMsg) -> Optional[Trace]:
    try:
        return trace_message.decode(message._buff, connection_header(message)["md5sum"])
    except TraceRefusedError as error:
        rospy.logwarn("not shown: %s", error)
        return None
