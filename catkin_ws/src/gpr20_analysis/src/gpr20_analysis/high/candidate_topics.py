"""Candidates as messages: their list, and markers that RViz and Foxglove show.

A message has no None: what is not known is NaN, and a list of positions is empty.
"""

from __future__ import annotations

import math
from typing import Any, Dict, List

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from gpr20_msgs.msg import AreaPosition
from gpr20_msgs.msg import Candidate as CandidateMessage
from gpr20_msgs.msg import CandidateList as CandidateListMessage
from gpr20_survey.results.candidates import CandidateList, candidate_record, list_record

LIST_TOPIC, MARKERS_TOPIC = "candidates", "candidate_markers"
# Smallest shown diameter, and height of the letters [m].
SMALLEST_M, LETTERS_M = 0.02, 0.015
PLAIN, DOUBTFUL = ColorRGBA(0.9, 0.1, 0.1, 0.8), ColorRGBA(0.9, 0.7, 0.1, 0.5)


class CandidateTopics:
    """The latched topics of one list; the ROS node must be initialized.

    Args:
        frame: Frame of the markers: X and Y of the axes, Z upwards from the ground [m].
    """

    def __init__(self, frame: str) -> None:
        self._frame = frame
        self._list = rospy.Publisher(LIST_TOPIC, CandidateListMessage, latch=True, queue_size=1)
        self._markers = rospy.Publisher(MARKERS_TOPIC, MarkerArray, latch=True, queue_size=1)

    def publish(self, found: CandidateList) -> None:
        """Publish a list and its markers, which replace former ones."""
        self._list.publish(list_message(found))
        self._markers.publish(marker_array(found, self._frame, rospy.Time.now()))


def list_message(found: CandidateList) -> CandidateListMessage:
    """Return the message of a list."""
    record = list_record(found)
    record["position"] = [AreaPosition(**one) for one in [record["position"]] if one]
    records = [candidate_record(one, found) for one in found.candidates]
    record["candidates"] = [_message(CandidateMessage, one) for one in records]
    return _message(CandidateListMessage, record)


def _message(kind: Any, record: Dict[str, Any]) -> Any:
    """Return the message with those values of a record that it has."""

    def sent(value: Any) -> Any:
        if isinstance(value, list):
            return [sent(one) for one in value]
        return math.nan if value is None else value

    return kind(**{name: sent(record[name]) for name in kind.__slots__})


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
