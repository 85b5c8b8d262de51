"""Publishes a list of candidates, and markers that RViz shows."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any, Dict

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from gpr20_analysis.candidates.candidate import (
    NO_CLEARANCE,
    SECONDARY,
    Candidate,
    CandidateList,
    Flag,
)
from gpr20_msgs.msg import Candidate as CandidateMessage
from gpr20_msgs.msg import CandidateList as CandidateListMessage

LIST_TOPIC, MARKERS_TOPIC = "candidates", "candidate_markers"
FRAME = "survey_area"
"""Frame of the markers: X and Y of the survey, Z upwards from the surface [m]."""
# Smallest shown diameter, and height of the letters [m].
SMALLEST_M, LETTERS_M = 0.02, 0.015
PLAIN, DOUBTFUL = ColorRGBA(0.9, 0.1, 0.1, 0.8), ColorRGBA(0.9, 0.7, 0.1, 0.5)
_DOUBTS = SECONDARY | {Flag.SURFACE_RESIDUE, Flag.UNRATED}


class CandidateTopics:
    """The latched topics of one list; the ROS node must be initialized."""

    def __init__(self) -> None:
        self._list = rospy.Publisher(LIST_TOPIC, CandidateListMessage, latch=True, queue_size=1)
        self._markers = rospy.Publisher(MARKERS_TOPIC, MarkerArray, latch=True, queue_size=1)

    def publish(self, found: CandidateList) -> None:
        """Publish a list and its markers, which replace former ones."""
        self._list.publish(list_message(found))
        self._markers.publish(marker_array(found))


def list_message(found: CandidateList) -> CandidateListMessage:
    """Return the message of a list."""
    return CandidateListMessage(
        warning=str(NO_CLEARANCE),
        survey_id=found.survey_id,
        simulated=found.simulated,
        method=found.method,
        permittivity=found.permittivity,
        permittivity_lowest=found.permittivity_range[0],
        permittivity_highest=found.permittivity_range[1],
        area_m2=found.area_m2,
        false_alarm_rate=found.false_alarm_rate,
        omitted=found.omitted,
        candidates=[_message(one) for one in found.candidates],
        notes=[str(note) for note in found.notes],
    )


def marker_array(found: CandidateList) -> MarkerArray:
    """Return a sphere and a name for each candidate; the first marker removes all former ones."""
    markers = [Marker(action=Marker.DELETEALL)]
    markers[0].header.frame_id = FRAME
    for number, one in enumerate(found.candidates):
        doubtful = bool(_DOUBTS & set(one.flags))
        size_m = [
            max(SMALLEST_M, 2.0 * each)
            for each in (one.x_uncertainty_m, one.y_uncertainty_m, one.depth_uncertainty_m)
        ]
        color = DOUBTFUL if doubtful else PLAIN
        body = {"ns": "candidates", "type": Marker.SPHERE, "scale": Vector3(*size_m)}
        name = {
            "ns": "names",
            "type": Marker.TEXT_VIEW_FACING,
            "scale": Vector3(0.0, 0.0, LETTERS_M),
            "text": f"{one.id} SIMULATED" if found.simulated else one.id,
        }
        markers += [_marker(number, one, {**kind, "color": color}) for kind in (body, name)]
    return MarkerArray(markers)


def _message(candidate: Candidate) -> CandidateMessage:
    values = asdict(candidate)
    if candidate.polarization_ratio_db is None:
        values["polarization_ratio_db"] = math.nan
    values["flags"] = [flag.value for flag in candidate.flags]
    return CandidateMessage(**values)


def _marker(number: int, candidate: Candidate, values: Dict[str, Any]) -> Marker:
    place = Point(candidate.x_m, candidate.y_m, -candidate.depth_m)
    marker = Marker(id=number, action=Marker.ADD, **values)
    marker.header.frame_id = FRAME
    marker.pose = Pose(place, Quaternion(0.0, 0.0, 0.0, 1.0))
    return marker
