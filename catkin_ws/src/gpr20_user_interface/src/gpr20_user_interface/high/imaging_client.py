"""The services of the imaging node, as events."""

from __future__ import annotations

from typing import Any, Callable, Sequence

from gpr20_common.errors import InvalidValueError
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_common.sent_message import message_from
from gpr20_msgs.msg import ImagingProgress
from gpr20_msgs.srv import (
    CancelImaging,
    ExportSurvey,
    FindCandidates,
    FocusSurvey,
    ListVolumes,
    MapHidden,
)
from gpr20_operator import faults
from gpr20_operator.jobs.imaging import (
    CandidatesFound,
    ExportDone,
    HidingMapped,
    ImageFailed,
    ImageFocused,
    RequestFailed,
    RequestProgress,
    VolumesFailed,
    VolumesListed,
)
from gpr20_operator.robot.senders import Senders
from gpr20_survey.results.candidate_json import list_from
from gpr20_survey.results.focused_image import image_from
from gpr20_survey.results.hiding_map import hiding_from
from gpr20_survey.results.volume import volume_from
from gpr20_user_interface.high.ros_events import RosEvents, in_background

# Longer than the node's own limits; another request may come first.
FOCUS_TIMEOUT_S = 360.0
LONG_TIMEOUT_S = 4 * 3600.0
SHORT_TIMEOUT_S = 20.0


class ImagingClient(RosEvents):
    """Asks the imaging node without waiting; passes its answers to a listener."""

    def __init__(self, listener: Callable[[object], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._focus = ServiceClient("focus_survey", FocusSurvey)
        self._find = ServiceClient("find_candidates", FindCandidates)
        self._hide = ServiceClient("map_hidden", MapHidden)
        self._export = ServiceClient("export_survey", ExportSurvey)
        self._volumes = ServiceClient("list_volumes", ListVolumes)
        self._cancel = ServiceClient("cancel_imaging", CancelImaging)

    def listen(self) -> None:
        """Subscribe to the progress of requests."""
        self._subscribe_raw("imaging_progress", ImagingProgress, self._on_progress, 20)

    def focus(self, survey_id: str, permittivity: float) -> None:
        """Ask for the focused image of a survey; permittivity 0: not known."""
        self._ask(
            lambda: self._focus.call(
                FOCUS_TIMEOUT_S, request_id="", survey=survey_id, permittivity=permittivity
            ),
            lambda response: ImageFocused(image_from(response)),
            lambda reason: ImageFailed(survey_id, reason),
        )

    def find_candidates(
        self, request_id: str, survey: str, permittivity: float, language: str
    ) -> None:
        """Ask for the candidates of a survey, by its id or folder; permittivity 0: not known."""
        self._ask(
            lambda: self._find.call(
                LONG_TIMEOUT_S,
                request_id=request_id,
                survey=survey,
                permittivity=permittivity,
                language=language,
            ),
            lambda response: CandidatesFound(
                request_id, list_from(response.candidates_json), response.remarks
            ),
            lambda reason: RequestFailed(request_id, reason),
        )

    def map_hidden(self, request_id: str, survey: str, permittivity: float, target: str) -> None:
        """Ask where a target could hide in a survey; permittivity 0: not known."""
        self._ask(
            lambda: self._hide.call(
                LONG_TIMEOUT_S,
                request_id=request_id,
                survey=survey,
                permittivity=permittivity,
                target=target,
            ),
            lambda response: HidingMapped(request_id, hiding_from(response.hiding_json)),
            lambda reason: RequestFailed(request_id, reason),
        )

    def export(
        self,
        request_id: str,
        survey: str,
        kinds: Sequence[str],
        permittivity: float,
        language: str,
        volume: str,
    ) -> None:
        """Ask to write parts of a survey to the stick that is mounted at a path."""
        self._ask(
            lambda: self._export.call(
                LONG_TIMEOUT_S,
                request_id=request_id,
                survey=survey,
                kinds=list(kinds),
                permittivity=permittivity,
                language=language,
                volume=volume,
            ),
            lambda response: ExportDone(request_id, tuple(response.files)),
            lambda reason: RequestFailed(request_id, reason),
        )

    def list_volumes(self) -> None:
        """Ask for the sticks."""
        self._ask(
            lambda: self._volumes.call(SHORT_TIMEOUT_S),
            lambda response: VolumesListed(
                response.computer,
                tuple(volume_from(one) for one in response.volumes),
            ),
            VolumesFailed,
        )

    def cancel(self, request_id: str) -> None:
        """Ask to end a request; if it cannot be ended, its own end says how it went."""
        self._ask(
            lambda: self._cancel.call(SHORT_TIMEOUT_S, request_id=request_id),
            lambda _response: None,
            lambda _reason: None,
        )

    def _on_progress(self, message: ImagingProgress) -> None:
        self._emit(RequestProgress(message.request_id, message_from(message)))

    def _ask(
        self,
        call: Callable[[], Any],
        convert: Callable[[Any], object],
        failed: Callable[[Message], object],
    ) -> None:
        def work() -> None:
            event = self._answer(call, convert, failed)
            if event is not None:
                self._emit(event)

        in_background(work)

    @staticmethod
    def _answer(
        call: Callable[[], Any],
        convert: Callable[[Any], object],
        failed: Callable[[Message], object],
    ) -> object:
        try:
            response = call()
            return convert(response) if response.success else failed(message_from(response))
        except ServiceUnavailableError as error:
            return failed(
                Message(
                    "the imaging node does not answer; check that it is running on the computer "
                    "of the storage",
                    details=error,
                ).with_fault(faults.PART_SILENT)
            )
        except InvalidValueError as error:
            return failed(error.message)
