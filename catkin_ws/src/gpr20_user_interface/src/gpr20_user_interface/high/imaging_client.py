"""The services of the imaging node, and those of the storage that a result needs, as jobs."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable, Dict, Optional, Tuple

import rospy

from gpr20_common.errors import InvalidValueError
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_common.sent_message import message_from
from gpr20_msgs import srv
from gpr20_msgs.msg import ImagingProgress
from gpr20_operator import faults
from gpr20_operator.jobs.job import Delivery, Ticket
from gpr20_operator.jobs.pictures import Service, Sticks, StoredSurvey
from gpr20_operator.robot.senders import Senders
from gpr20_survey.results.focused_image import image_from
from gpr20_survey.results.hiding_map import hiding_from
from gpr20_survey.results.volume import volume_from
from gpr20_user_interface.high.ros_events import RosEvents, in_background

# Longer than the node's own limits; other requests may come first.
LONG_TIMEOUT_S = 4 * 3600.0
SHORT_TIMEOUT_S = 20.0
# Another request, such as closing a large survey, may come first.
NOTE_TIMEOUT_S = 60.0
# Class and time limit [s] of each service, and what its answer becomes.
SERVICES: Dict[Service, Tuple[Any, float, Callable[[Any], Any]]] = {
    Service.FOCUS: (srv.FocusSurvey, LONG_TIMEOUT_S, image_from),
    Service.HIDE: (srv.MapHidden, LONG_TIMEOUT_S, lambda one: hiding_from(one.hiding_json)),
    Service.EXPORT: (srv.ExportSurvey, LONG_TIMEOUT_S, lambda one: tuple(one.files)),
    Service.STICKS: (
        srv.ListVolumes,
        SHORT_TIMEOUT_S,
        lambda one: Sticks(one.computer, tuple(map(volume_from, one.volumes))),
    ),
    Service.READ: (
        srv.ReadSurvey,
        SHORT_TIMEOUT_S,
        lambda one: StoredSurvey(one.metadata_json, len(one.stored_indices)),
    ),
    Service.NOTE: (srv.NoteSurvey, NOTE_TIMEOUT_S, lambda _one: None),
}


class ImagingClient(RosEvents):
    """Asks without waiting, see `ImagingRequests`; answers are deliveries for a listener."""

    def __init__(self, listener: Callable[[object], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._clients = {one: ServiceClient(one.value, kind[0]) for one, kind in SERVICES.items()}
        self._cancel = ServiceClient("cancel_imaging", srv.CancelImaging)
        # The export alone reports its progress.
        self._exporting: Optional[Ticket[Any]] = None

    def listen(self) -> None:
        """Subscribe to the progress of requests."""
        self._subscribe_raw("imaging_progress", ImagingProgress, self._on_progress, 20)

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        """Call a service in the background, and let the ticket take the answer."""
        if service.can_be_cancelled:
            fields["request_id"] = ticket.request_id
        if service is Service.EXPORT:
            self._exporting = ticket
        in_background(lambda: self._emit(Delivery(self._answer(service, ticket, fields))))

    def cancel(self, request_id: str) -> None:
        """Ask to end a request of a ticket."""

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
        _kind, timeout_s, convert = SERVICES[service]
        try:
            response = self._clients[service].call(timeout_s, **fields)
            if response.success:
                return partial(ticket.done, convert(response))
            return partial(ticket.fail, message_from(response))
        except ServiceUnavailableError as error:
            return partial(ticket.fail, _silent(service, error))
        except InvalidValueError as error:
            return partial(ticket.fail, error.message)

    def _on_progress(self, message: ImagingProgress) -> None:
        ticket, stage = self._exporting, message_from(message)
        if ticket is not None and message.request_id == ticket.request_id:
            self._emit(Delivery(partial(ticket.progress, stage)))


def _silent(service: Service, error: ServiceUnavailableError) -> Message:
    reason = Message(
        "the imaging node does not answer; check that it is running on the computer of the storage",
        details=error,
    )
    if service in (Service.READ, Service.NOTE):
        reason = Message("the storage does not answer; check that it is running", details=error)
    return reason.with_fault(faults.PART_SILENT)
