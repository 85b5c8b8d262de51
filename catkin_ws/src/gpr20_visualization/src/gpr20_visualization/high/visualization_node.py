"""The node visualization: the robot and its survey in standard ROS messages."""

from __future__ import annotations

import math
import threading
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import rospkg
import rospy
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Vector3
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import ColorRGBA, Header, String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.high.node import run_node
from gpr20_common.high.raw_message import connection_header, ros_time
from gpr20_common.message import Message
from gpr20_msgs.msg import Coordinates
from gpr20_survey.axes import BASE_LINK, MAP
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.recording.survey_topics import METADATA_TOPIC, TRACE_TOPIC
from gpr20_survey.trace import trace_message
from gpr20_visualization.mid.robot_model import LinkTransform, RobotModel, joint_positions
from gpr20_visualization.mid.survey_picture import SurveyPicture, area_of

NODE = "visualization"
DESCRIPTION = "robot_description"
LATCHED = {"tf_static", DESCRIPTION, "b_scan", "survey_area", "stops"}
TYPES = {
    "tf": TFMessage,
    "tf_static": TFMessage,
    "joint_states": JointState,
    DESCRIPTION: String,
    "b_scan": Image,
    "survey_area": Marker,
    "stops": Marker,
}
# Traces of a replay that starts late come all at once.
TRACE_QUEUE = 1000
GREY = "mono8"
OUTLINE_M, STOP_M = 0.004, 0.008
OUTLINE, STOPS = ColorRGBA(0.1, 0.5, 0.9, 1.0), ColorRGBA(0.1, 0.7, 0.2, 1.0)
# Where the robot is on its map: its origin is that of the map.
ROBOT_PLACE = LinkTransform(MAP, BASE_LINK, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
Places = Sequence[Tuple[float, float]]


class VisualizationNode:
    """Turns positions, traces and descriptions of surveys into standard messages.

    A topic is advertised with its first message.
    """

    def __init__(self, urdf: str) -> None:
        """Connect everything.

        Args:
            urdf: Description of the robot.

        Raises:
            Gpr20Error: The description cannot be used.
        """
        self._urdf = urdf
        self._model = RobotModel.of(urdf)
        self._lock = threading.Lock()  # guards everything below
        self._publishers: Dict[str, rospy.Publisher] = {}
        self._survey = SurveyPicture()
        self._corners: Optional[List[Tuple[float, float]]] = None
        self._problem: Optional[Message] = None
        self._subscribers = [
            rospy.Subscriber(
                "control_current_coordinate", Coordinates, self._position, queue_size=10
            ),
            rospy.Subscriber(METADATA_TOPIC, String, self._survey_description, queue_size=10),
            rospy.Subscriber(TRACE_TOPIC, rospy.AnyMsg, self._trace, queue_size=TRACE_QUEUE),
        ]
        self._diagnostics = Diagnostics(NODE, self._health)

    def _position(self, message: Coordinates) -> None:
        positions = joint_positions(message.x_mm, message.y_mm, message.z_deg)
        if not all(math.isfinite(one) for one in positions.values()):
            return  # tf2 would report an error for each
        stamp = message.header.stamp
        with self._lock:
            if "tf" not in self._publishers:
                fixed = [ROBOT_PLACE, *self._model.fixed()]
                self._publish("tf_static", _transforms(fixed, stamp))
                self._publish(DESCRIPTION, String(self._urdf))
            self._publish("tf", _transforms(self._model.moving(positions), stamp))
            self._publish("joint_states", _joint_state(positions, stamp))
            self._publish_area(stamp)

    def _survey_description(self, message: String) -> None:
        area = area_of(message.data)
        with self._lock:
            self._survey.set_area(area)
            # Shown with the stamp of what comes next, live or recorded.
            self._corners = [] if area is None else area.outline()

    def _trace(self, message: rospy.AnyMsg) -> None:
        try:
            trace = trace_message.decode(message._buff, connection_header(message)["md5sum"])
        except TraceRefusedError as error:
            rospy.logwarn("a trace cannot be shown: %s", error)
            with self._lock:
                self._problem = error.message.as_warning()
            return
        with self._lock:
            self._publish_area(ros_time(trace.timestamp_us))
            picture = self._survey.add(trace)
            if picture is not None:
                stamp = ros_time(self._survey.ended_us)
                self._publish("b_scan", _image(picture, stamp))
                self._publish("stops", _stops(self._survey.stops_m, stamp))

    def _publish_area(self, stamp: rospy.Time) -> None:
        if self._corners is not None:
            self._publish("survey_area", _outline(self._corners, stamp))
            self._corners = None

    def _publish(self, topic: str, message: Any) -> None:
        if topic not in self._publishers:
            latch = topic in LATCHED
            self._publishers[topic] = rospy.Publisher(
                topic, TYPES[topic], queue_size=10, latch=latch
            )
        self._publishers[topic].publish(message)

    def _health(self) -> Health:
        with self._lock:
            if self._problem is not None:
                return WARN, self._problem, {}
        return OK, Message("shows the robot and its survey"), {}


def robot_description() -> str:
    """Return the URDF that the launch has set, else that of this package.

    Raises:
        OSError: It cannot be read.
    """
    text = rospy.get_param(DESCRIPTION, "")
    if isinstance(text, str) and text:
        return text
    package = Path(rospkg.RosPack().get_path("gpr20_visualization"))
    return (package / "urdf" / "gpr20.urdf").read_text(encoding="utf-8")


def _transforms(found: Iterable[LinkTransform], stamp: rospy.Time) -> TFMessage:
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


def _joint_state(positions: Mapping[str, float], stamp: rospy.Time) -> JointState:
    """Return the position of the joints [m or rad]."""
    return JointState(Header(stamp=stamp), list(positions), list(positions.values()), [], [])


def _image(picture: np.ndarray, stamp: rospy.Time) -> Image:
    """Return a grey picture (rows x columns, uint8)."""
    rows, columns = picture.shape
    header = Header(stamp=stamp, frame_id=BASE_LINK)
    return Image(header, rows, columns, GREY, 0, columns, picture.tobytes())


def _outline(corners: Places, stamp: rospy.Time) -> Marker:
    """Return the area of a survey on the ground; none without corners."""
    return _marker(
        "survey_area", Marker.LINE_STRIP, Vector3(OUTLINE_M, 0.0, 0.0), OUTLINE, corners, stamp
    )


def _stops(places: Places, stamp: rospy.Time) -> Marker:
    """Return the measured stops on the ground; none without places."""
    size = Vector3(STOP_M, STOP_M, STOP_M)
    return _marker("stops", Marker.SPHERE_LIST, size, STOPS, places, stamp)


def _marker(
    name: str,
    kind: int,
    size: Vector3,
    color: ColorRGBA,
    places: Places,
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


def main() -> None:
    """Run the node."""
    run_node(NODE, lambda: VisualizationNode(robot_description()))
