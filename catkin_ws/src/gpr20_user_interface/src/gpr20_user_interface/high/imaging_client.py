"""The services of the imaging node, and those of the storage that a result needs, as jobs."""

from __future__ import annotations

import json
from functools import partial
from typing import Any, Callable, Mapping, Optional, Tuple

import rospy

from gpr20_common.errors import InvalidValueError
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import ImagingProgress
from gpr20_msgs.srv import (
    CancelImaging,
    ExportSurvey,
    FocusSurvey,
    ListVolumes,
    MapHidden,
    NoteSurvey,
    ReadSurvey,
)
from gpr20_operator import faults
from gpr20_operator.jobs.job import Delivery, Ticket
from gpr20_operator.jobs.pictures import ExportOrder, Sticks, StoredSurvey
from gpr20_operator.robot.senders import Senders
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.results.focused_image import FocusedImage, image_from
from gpr20_survey.results.hiding_map import HidingMap, hiding_from
from gpr20_survey.results.volume import volume_from
from gpr20_user_interface.high.ros_events import RosEvents, in_background

# Longer than the node's own limits; other requests may come first.
LONG_TIMEOUT_S = 4 * 3600.0
SHORT_TIMEOUT_S = 20.0
# Another request, such as closing a large survey, may come first.
NOTE_TIMEOUT_S = 60.0
NO_IMAGING = Message(
    "the imaging node does not answer; check that it is running on the computer of the storage"
)
NO_STORAGE = Message("the storage does not answer; check that it is running")


class ImagingClient(RosEvents):
    """Asks without waiting, see `ImagingRequests`; answers are deliveries for a listener."""

    def __init__(self, listener: Callable[[object], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._focus = ServiceClient("focus_survey", FocusSurvey)
        self._hide = ServiceClient("map_hidden", MapHidden)
        self._export = ServiceClient("export_survey", ExportSurvey)
        self._volumes = ServiceClient("list_volumes", ListVolumes)
        self._cancel = ServiceClient("cancel_imaging", CancelImaging)
        self._read = ServiceClient("read_survey", ReadSurvey)
        self._note = ServiceClient("note_survey", NoteSurvey)
        # The export alone reports its progress.
        self._exporting: Optional[Ticket[Any]] = None

    def listen(self) -> None:
        """Subscribe to the progress of requests."""
        self._subscribe_raw("imaging_progress", ImagingProgress, self._on_progress, 20)

    def focus(self, ticket: Ticket[FocusedImage], survey: str, permittivity: float) -> None:
        """Ask for the focused image of a survey and the candidates in it."""
        wanted = {"survey": survey, "permittivity": permittivity}
        self._ask(ticket, self._long(self._focus, ticket, wanted), image_from)

    def map_hidden(
        self, ticket: Ticket[HidingMap], survey: str, permittivity: float, target: str
    ) -> None:
        """Ask where a target could hide."""
        wanted = {"survey": survey, "permittivity": permittivity, "target": target}
        call = self._long(self._hide, ticket, wanted)
        self._ask(ticket, call, lambda response: hiding_from(response.hiding_json))

    def export(self, ticket: Ticket[Tuple[str, ...]], order: ExportOrder) -> None:
        """Ask to write files; the answer is their names on the stick."""
        self._exporting = ticket
        call = self._long(self._export, ticket, vars(order))
        self._ask(ticket, call, lambda response: tuple(response.files))

    def list_volumes(self, ticket: Ticket[Sticks]) -> None:
        """Ask for the sticks."""
        self._ask(ticket, lambda: self._volumes.call(SHORT_TIMEOUT_S), _sticks_from)

    def read_survey(self, ticket: Ticket[StoredSurvey], survey: str) -> None:
        """Ask what the storage has of a survey."""
        self._ask(
            ticket,
            lambda: self._read.call(SHORT_TIMEOUT_S, survey=survey),
            lambda response: StoredSurvey(response.metadata_json, len(response.stored_indices)),
            NO_STORAGE,
        )

    def note(
        self, ticket: Ticket[None], survey: str, kind: Kind, values: Mapping[str, Any]
    ) -> None:
        """Ask to add a fact to the log of a survey, durably."""
        fact = {"survey": survey, "kind": kind.value, "values_json": json.dumps(values)}
        call = partial(self._note.call, NOTE_TIMEOUT_S, **fact)
        self._ask(ticket, call, lambda _response: None, NO_STORAGE)

    def cancel(self, request_id: str) -> None:
        """Ask to end a request of a ticket."""

        def work() -> None:
            try:
                self._cancel.call(SHORT_TIMEOUT_S, request_id=request_id)
            except ServiceUnavailableError as error:
                # The job takes no answer any more; without a node there is nothing to end.
                rospy.loginfo("not cancelled: %s", error)

        in_background(work)

    def _on_progress(self, message: ImagingProgress) -> None:
        ticket, stage = self._exporting, message_from(message)
        if ticket is not None and message.request_id == ticket.request_id:
            self._emit(Delivery(partial(ticket.progress, stage)))

    @staticmethod
    def _long(
        service: ServiceClient, ticket: Ticket[Any], wanted: Mapping[str, Any]
    ) -> Callable[[], Any]:
        return partial(service.call, LONG_TIMEOUT_S, request_id=ticket.request_id, **wanted)

    def _ask(
        self,
        ticket: Ticket[Any],
        call: Callable[[], Any],
        convert: Callable[[Any], Any],
        silent: Message = NO_IMAGING,
    ) -> None:
        """Call a service in the background, and let the ticket take the converted answer."""

        def answer() -> Callable[[], None]:
            try:
                response = call()
                if response.success:
                    return partial(ticket.done, convert(response))
                return partial(ticket.fail, message_from(response))
            except ServiceUnavailableError as error:
                reason = Message(silent.template, details=error)
                return partial(ticket.fail, reason.with_fault(faults.PART_SILENT))
            except InvalidValueError as error:
                return partial(ticket.fail, error.message)

        in_background(lambda: self._emit(Delivery(answer())))


def _sticks_from(response: Any) -> Sticks:
    return Sticks(response.computer, tuple(volume_from(one) for one in response.volumes))
