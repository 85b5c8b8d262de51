"""Candidates as messages: their list, and markers that RViz and Foxglove show."""

from __future__ import annotations

import json
import math
from typing import Any, Dict, List, Mapping, Optional

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from gpr20_msgs.msg import Candidate, CandidateList

LIST_TOPIC, MARKERS_TOPIC = "candidates", "candidate_markers"
# Smallest shown diameter, and height of the letters [m].
SMALLEST_M, LETTERS_M = 0.02, 0.015
PLAIN, DOUBTFUL = ColorRGBA(0.9, 0.1, 0.1, 0.8), ColorRGBA(0.9, 0.7, 0.1, 0.5)
DOUBTS = frozenset({"clutter", "sidelobe", "surface-residue", "unrated"})


class CandidateTopics:
    """The latched topics of one list; the ROS node must be initialized.

    Args:
        frame: Frame of the markers: X and Y of the axes, Z upwards from the ground [m].
    """

    def __init__(self, frame: str) -> None:
        self._frame = frame
        self._list = rospy.Publisher(LIST_TOPIC, CandidateList, latch=True, queue_size=1)
        self._markers = rospy.Publisher(MARKERS_TOPIC, MarkerArray, latch=True, queue_size=1)

    def publish(self, text: str) -> None:
        """Publish a list and its markers, which replace former ones.

        Args:
            text: What `gpr20 candidates --json` prints.
        """
        found = list_message(json.loads(text))
        self._list.publish(found)
        self._markers.publish(marker_array(found, self._frame, rospy.Time.now()))


def list_message(record: Mapping[str, Any]) -> CandidateList:
    """Return the message of a list.

    Args:
        record: The object that `gpr20 candidates --json` prints.
    """
    plain = [name for name in CandidateList.__slots__ if name != "candidates"]
    candidates = [_candidate(one) for one in record["candidates"]]
    return CandidateList(candidates=candidates, **{name: record[name] for name in plain})


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
        color = DOUBTFUL if DOUBTS & set(one.flags) else PLAIN
        place = Point(one.x_m, one.y_m, -one.depth_m)
        common: Dict[str, Any] = {
            "header": header,
            "id": number,
            "action": Marker.ADD,
            "color": color,
            "pose": Pose(place, Quaternion(0.0, 0.0, 0.0, 1.0)),
        }
        markers += [Marker(**common, **kind) for kind in (body, name)]
    return MarkerArray(markers)


def _candidate(record: Mapping[str, Any]) -> Candidate:
    values = {name: record[name] for name in Candidate.__slots__}
    values["rotations_deg"] = [_number(one) for one in record["rotations_deg"]]
    for name in ("above_noise_db", "polarization_ratio_db"):
        values[name] = _number(record[name])
    return Candidate(**values)


def _number(value: Optional[float]) -> float:
    return math.nan if value is None else value
