"""The node visualization: the robot and its survey in standard ROS messages."""

from __future__ import annotations

import math
import threading
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import rospkg
import rospy
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.high.node import run_node
from gpr20_common.high.raw_message import connection_header, ros_time
from gpr20_common.message import Message
from gpr20_msgs.msg import Coordinates
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.recording.survey_topics import METADATA_TOPIC, TRACE_TOPIC
from gpr20_survey.trace import trace_message
from gpr20_visualization.high import messages
from gpr20_visualization.mid.robot_model import JOINTS, RobotModel, joint_positions
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
        self._model = RobotModel.of(urdf, JOINTS)
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
                fixed = [messages.ROBOT_PLACE, *self._model.fixed()]
                self._publish("tf_static", messages.transforms(fixed, stamp))
                self._publish(DESCRIPTION, String(self._urdf))
            self._publish("tf", messages.transforms(self._model.moving(positions), stamp))
            self._publish("joint_states", messages.joint_state(positions, stamp))
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
                self._publish("b_scan", messages.image(picture, stamp))
                self._publish("stops", messages.stops(self._survey.stops_m, stamp))

    def _publish_area(self, stamp: rospy.Time) -> None:
        if self._corners is not None:
            self._publish("survey_area", messages.outline(self._corners, stamp))
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


def main() -> None:
    """Run the node."""
    run_node(NODE, lambda: VisualizationNode(robot_description()))
