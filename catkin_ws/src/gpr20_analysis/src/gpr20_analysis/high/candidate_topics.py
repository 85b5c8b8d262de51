"""Candidates as messages: their list as JSON, and markers that RViz and Foxglove show."""

from __future__ import annotations

from typing import Any, Dict, List

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header, String
from visualization_msgs.msg import Marker, MarkerArray

from gpr20_survey.results.candidates import CandidateList, json_text

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
        self._list = rospy.Publisher(LIST_TOPIC, String, latch=True, queue_size=1)
        self._markers = rospy.Publisher(MARKERS_TOPIC, MarkerArray, latch=True, queue_size=1)

    def publish(self, found: CandidateList) -> None:
        """Publish a list and its markers, which replace former ones."""
        self._list.publish(json_text(found))
        self._markers.publish(marker_array(found, self._frame, rospy.Time.now()))


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
