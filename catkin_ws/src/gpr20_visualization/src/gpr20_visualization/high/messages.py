"""What is shown, as messages of the standard types."""

from __future__ import annotations

from typing import Iterable, List, Mapping, Sequence, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Vector3
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import ColorRGBA, Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from gpr20_survey.axes.axis_id import BASE_LINK, MAP
from gpr20_visualization.mid.robot_model import LinkTransform

GREY = "mono8"
OUTLINE_M, STOP_M = 0.004, 0.008
OUTLINE, STOPS = ColorRGBA(0.1, 0.5, 0.9, 1.0), ColorRGBA(0.1, 0.7, 0.2, 1.0)
ROBOT_PLACE = LinkTransform(MAP, BASE_LINK, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
"""Where the robot is on its map: its origin is that of the map."""


def transforms(found: Iterable[LinkTransform], stamp: rospy.Time) -> TFMessage:
    """Return transforms as one message."""
    return TFMessage(
        [
            TransformStamped(
                Header(stamp=stamp, frame_id=one.parent),
                one.child,
                Transform(Vector3(*one.place_m), Quaternion(*one.rotation)),
            )
            for one in found
        ]
    )


def joint_state(positions: Mapping[str, float], stamp: rospy.Time) -> JointState:
    """Return the position of the joints [m or rad]."""
    return JointState(Header(stamp=stamp), list(positions), list(positions.values()), [], [])


def image(picture: np.ndarray, stamp: rospy.Time) -> Image:
    """Return a grey picture (rows x columns, uint8)."""
    rows, columns = picture.shape
    header = Header(stamp=stamp, frame_id=BASE_LINK)
    return Image(header, rows, columns, GREY, 0, columns, picture.tobytes())


def outline(corners: Sequence[Tuple[float, float]], stamp: rospy.Time) -> Marker:
    """Return the area of a survey on the ground; none without corners."""
    return _marker(
        "survey_area", Marker.LINE_STRIP, Vector3(OUTLINE_M, 0.0, 0.0), OUTLINE, corners, stamp
    )


def stops(places: Sequence[Tuple[float, float]], stamp: rospy.Time) -> Marker:
    """Return the measured stops on the ground; none without places."""
    size = Vector3(STOP_M, STOP_M, STOP_M)
    return _marker("stops", Marker.SPHERE_LIST, size, STOPS, places, stamp)


def _marker(
    name: str,
    kind: int,
    size: Vector3,
    color: ColorRGBA,
    places: Sequence[Tuple[float, float]],
    stamp: rospy.Time,
) -> Marker:
    points: List[Point] = [Point(x_m, y_m, 0.0) for x_m, y_m in places]
    marker = Marker(
        header=Header(stamp=stamp, frame_id=BASE_LINK),
        ns=name,
        type=kind,
        action=Marker.ADD if points else Marker.DELETE,
        scale=size,
        color=color,
        points=points,
    )
    marker.pose.orientation.w = 1.0
    return marker
