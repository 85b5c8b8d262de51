"""The node imaging: focused images, candidates, which it also publishes, and exports."""

from __future__ import annotations

import json
import os
from typing import Any, Dict, List, Optional, Sequence

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header, String
from visualization_msgs.msg import Marker, MarkerArray

from gpr20_common.high.answers import advertise, fields_of, message_fields, message_from
from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.high.node import publish_description, read_parameters, run_node
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.low.yaml_file import data_folder
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NO_HARDWARE
from gpr20_imaging.low.stick_files import UsbVolumes
from gpr20_imaging.low.worker_process import WorkerProcess
from gpr20_imaging.mid.imaging import Imaging, ImagingParameters
from gpr20_msgs.msg import ImagingProgress, Volume
from gpr20_msgs.srv import (
    AddFact,
    CancelImaging,
    CancelImagingResponse,
    ExportSurvey,
    ExportSurveyResponse,
    FocusSurvey,
    FocusSurveyResponse,
    ListVolumes,
    ListVolumesResponse,
    MapHidden,
    MapHiddenResponse,
)
from gpr20_survey.axes import BASE_LINK
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.results.answers import focus_fields
from gpr20_survey.results.candidates import CandidateList, json_text
from gpr20_survey.results.hiding_map import hiding_json
from gpr20_survey.trace.utc_time import iso_text

NODE = "imaging"
NOTE_LIMIT_S = 20.0
# Smallest shown diameter, and height of the letters [m].
SMALLEST_M, LETTERS_M = 0.02, 0.015
PLAIN, DOUBTFUL = ColorRGBA(0.9, 0.1, 0.1, 0.8), ColorRGBA(0.9, 0.7, 0.1, 0.5)


def marker_array(found: CandidateList, frame: str, stamp: rospy.Time) -> MarkerArray:
    """Return a sphere and a name for each candidate; the first marker removes all former ones."""
    header = Header(stamp=stamp, frame_id=frame)
    markers: List[Marker] = [Marker(header=header, action=Marker.DELETEALL)]
    for number, one in enumerate(found.candidates):
        size_m = [
            max(SMALLEST_M, 2.0 * each)
            for each in (one.x_uncertainty_m, one.y_uncertainty_m, one.depth_uncertainty_m)
        ]
        body = {"ns": "candidates", "type": Marker.SPHERE, "scale": Vector3(*size_m)}
        name = {
            "ns": "names",
            "type": Marker.TEXT_VIEW_FACING,
            "scale": Vector3(0.0, 0.0, LETTERS_M),
            "text": f"{one.id} SIMULATED" if found.simulated else one.id,
        }
        common: Dict[str, Any] = {
            "header": header,
            "id": number,
            "action": Marker.ADD,
            "color": DOUBTFUL if one.is_doubtful else PLAIN,
            "pose": Pose(Point(one.x_m, one.y_m, -one.depth_m), Quaternion(0.0, 0.0, 0.0, 1.0)),
        }
        markers += [Marker(**common, **kind) for kind in (body, name)]
    return MarkerArray(markers)


class ImagingNode:
    """Turns requests into calls of Imaging and its answers into messages."""

    def __init__(self, parameters: ImagingParameters, volumes: UsbVolumes) -> None:
        """Connect everything; no child process is started before the first request."""
        self._progress = rospy.Publisher("imaging_progress", ImagingProgress, queue_size=20)
        self._candidates = rospy.Publisher("candidates", String, latch=True, queue_size=1)
        # As RViz and Foxglove show them.
        self._markers = rospy.Publisher("candidate_markers", MarkerArray, latch=True, queue_size=1)
        self._sticks = volumes
        data = data_folder(parameters.data, os.environ)
        self._imaging = Imaging(
            data, WorkerProcess(), self._publish_progress, self._publish_candidates
        )
        self._facts = ServiceClient("add_fact", AddFact)
        rospy.on_shutdown(self._imaging.close)
        self._services = [
            advertise("focus_survey", FocusSurvey, self._focus),
            advertise("map_hidden", MapHidden, self._hide),
            advertise("export_survey", ExportSurvey, self._export),
            advertise("list_volumes", ListVolumes, self._volumes),
            advertise("cancel_imaging", CancelImaging, self._cancel),
        ]
        self._diagnostics = Diagnostics(NODE, self._health)
        self._description = publish_description(NODE, NO_HARDWARE, parameters)

    def _focus(self, request: Any) -> FocusSurveyResponse:
        found = self._imaging.focus(
            request.request_id, request.survey, request.permittivity, request.only_known
        )
        message = Message("an image of {count} traces", count=found.traces)
        return FocusSurveyResponse(success=True, **message_fields(message), **focus_fields(found))

    def _hide(self, request: Any) -> MapHiddenResponse:
        found = self._imaging.map_hidden(
            request.request_id, request.survey, request.permittivity, request.target
        )
        made = message_fields(Message("the map is complete"))
        return MapHiddenResponse(success=True, **made, hiding_json=hiding_json(found))

    def _export(self, request: Any) -> ExportSurveyResponse:
        files, content = self._imaging.export(
            request.request_id,
            request.survey,
            request.kinds,
            request.permittivity,
            request.language,
            request.volume,
        )
        if content:
            made = message_fields(Message("the file is made"))
            return ExportSurveyResponse(success=True, **made, files=files, content=content)
        message = Message("{count} files are on the USB stick", count=len(files))
        not_noted = self._note_export(request.survey, files, request.volume)
        if not_noted is not None:
            message = Message(
                "{exported}; the log of the survey does not say so: {reason}",
                exported=message,
                reason=not_noted,
            )
        return ExportSurveyResponse(success=True, **message_fields(message), files=files)

    def _note_export(self, survey: str, files: Sequence[str], volume: str) -> Optional[Message]:
        """Note it in the log of the survey, which the storage writes; return why not, or None."""
        values = {"time": iso_text(time_of_day_us()), "files": list(files), "volume": volume}
        fields = {"survey": survey, "kind": Kind.EXPORT.value, "values_json": json.dumps(values)}
        try:
            response = self._facts.call(NOTE_LIMIT_S, **fields)
        except ServiceUnavailableError as error:
            return error.message
        return None if response.success else message_from(response)

    def _volumes(self, _request: Any) -> ListVolumesResponse:
        found = self._sticks.mounted()
        return ListVolumesResponse(
            success=True,
            **message_fields(Message("{count} USB sticks", count=len(found))),
            computer=self._imaging.computer,
            volumes=[Volume(**fields_of(one, Volume)) for one in found],
        )

    def _cancel(self, request: Any) -> CancelImagingResponse:
        self._imaging.cancel(request.request_id)
        done = message_fields(Message("the request is cancelled"))
        return CancelImagingResponse(success=True, **done)

    def _publish_progress(self, request_id: str, stage: Message) -> None:
        self._progress.publish(ImagingProgress(request_id=request_id, **message_fields(stage)))

    def _publish_candidates(self, found: CandidateList) -> None:
        self._candidates.publish(json_text(found))
        self._markers.publish(marker_array(found, BASE_LINK, rospy.Time.now()))

    def _health(self) -> Health:
        missing = self._imaging.missing
        values = {"computer": self._imaging.computer, "requests": self._imaging.requests}
        if missing is not None:
            return WARN, missing.as_warning(), values
        return OK, Message("ready for images, candidates and exports"), values


def main() -> None:
    """Run the node."""
    run_node(NODE, lambda: ImagingNode(read_parameters(ImagingParameters, NODE), UsbVolumes()))
