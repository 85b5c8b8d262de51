"""The services that jobs of the window ask: of the imaging node, the storage and the robot."""

from __future__ import annotations

import os
import socket
from functools import partial
from typing import Any, Callable, Dict, Mapping, NamedTuple, Optional

import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.high.answers import message_from, record_of
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_doctor.high.node_reports import analyzer_test_of
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import ThisMachine
from gpr20_msgs import srv
from gpr20_msgs.msg import ImagingProgress
from gpr20_operator.high.conversions import fact_fields, surveys_listed
from gpr20_operator.high.ros_events import (
    CONTROL_SILENT,
    STORAGE_SILENT,
    RequestError,
    RosEvents,
    accepted,
    call,
    in_background,
)
from gpr20_operator.jobs.job import Delivery, Service, Ticket
from gpr20_operator.jobs.pictures import Exported, Sticks, StoredSurvey
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.service_model import HeightTested
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.focused_image import image_from
from gpr20_survey.results.hiding_map import hiding_from
from gpr20_survey.results.volume import Volume

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
        lambda one: StoredSurvey(accepted(one).metadata_json, len(one.stored_indices)),
    ),
    Service.LIST: _Offer(
        *(srv.ListSurveys, SHORT_TIMEOUT_S, STORAGE_SILENT),
        lambda one: surveys_listed("", accepted(one)),
    ),
    Service.FACT: _Offer(srv.AddFact, FACT_TIMEOUT_S, STORAGE_SILENT, _said),
    Service.MOVE: _Offer(srv.ServiceMove, MOVE_TIMEOUT_S, CONTROL_SILENT, _said),
    # A test that failed says what it has found before.
    Service.HEIGHT: _Offer(
        *(srv.GetHeight, HEIGHT_TIMEOUT_S, HEIGHT_SILENT),
        _height_tested,
    ),
    Service.ANALYZER: _Offer(
        srv.TestAnalyzer, ANALYZER_TIMEOUT_S, CONTROL_SILENT, analyzer_test_of
    ),
    Service.DAILY: _Offer(srv.DailyCheck, ANALYZER_TIMEOUT_S, CONTROL_SILENT, _said),
}


class RequestClient(RosEvents):
    """Asks without waiting, see `Requests`; answers are deliveries for a listener."""

    def __init__(self, listener: Callable[[object], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._clients = {one: ServiceClient(one.value, offer.kind) for one, offer in OFFERS.items()}
        self._cancel = ServiceClient("cancel_imaging", srv.CancelImaging)
        # The export alone reports its progress.
        self._exporting: Optional[Ticket[Any]] = None

    def listen(self) -> None:
        self._subscribe("imaging_progress", ImagingProgress, self._on_progress, 20)

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        """Call a service in the background, and let the ticket take the answer."""
        if service.can_be_cancelled:
            fields["request_id"] = ticket.request_id
        if service is Service.EXPORT:
            self._exporting = ticket
        in_background(lambda: self._emit(Delivery(self._answer(service, ticket, fields))))

    def wait_for(self, service: Service, **fields: Any) -> Any:
        """Call a service in this thread, and return what its answer becomes.

        Raises:
            RequestError: Its node does not answer, or refuses.
            Gpr20Error: The answer is not as it should be.
        """
        if service is Service.FACT:
            fields = fact_fields(**fields)
        offer = OFFERS[service]
        response = call(self._clients[service], offer.silent, offer.timeout_s, **fields)
        return offer.convert(response)

    def examine(
        self,
        ticket: Ticket[MachineFacts],
        nodes: Mapping[str, NodeDescription],
        surveying: bool,
        thorough: bool,
    ) -> None:
        """Look at this computer in the background."""

        def look() -> None:
            machine = ThisMachine(socket.gethostname(), os.environ)
            facts = probe_machine(machine.request(nodes, surveying, thorough=thorough))
            self._emit(Delivery(partial(ticket.done, facts)))

        in_background(look)

    def cancel(self, request_id: str) -> None:

        def work() -> None:
            try:
                self._cancel.call(SHORT_TIMEOUT_S, request_id=request_id)
            except ServiceUnavailableError as error:
                # The job takes no answer any more; without a node there is nothing to end.
                rospy.loginfo("not cancelled: %s", error)

        in_background(work)

    def _answer(
        self, service: Service, ticket: Ticket[Any], fields: Dict[str, Any]
    ) -> Callable[[], None]:
        """Return what is to be called in the thread of the job."""
        try:
            return partial(ticket.done, self.wait_for(service, **fields))
        except (RequestError, Gpr20Error) as error:
            return partial(ticket.fail, error.message)

    def _on_progress(self, message: ImagingProgress) -> Optional[Delivery]:
        ticket = self._exporting
        if ticket is None or message.request_id != ticket.request_id:
            return None
        return Delivery(partial(ticket.progress, message_from(message)))
