"""The node visualization: the robot and its survey in standard ROS messages."""

from __future__ import annotations

import math
import threading
from pathlib import Path
from typing import Any, Dict, Optional

import rosgraph
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
from gpr20_visualization.mid.axis_position import JOINTS, joint_positions
from gpr20_visualization.mid.robot_model import RobotModel
from gpr20_visualization.mid.survey_picture import FinishedLine, SurveyPicture, area_of


class Senders:
    """Recognizes the players of recordings that hold tf and joint_states already.

    What they publish must not be published a second time.
    """

    def __init__(self, topic: str) -> None:
        """Recognize nodes that publish a topic, which this node publishes too."""
        self._topic = rospy.resolve_name(topic)
        self._lock = threading.Lock()  # guards the one below
        self._known: Dict[str, bool] = {}

    def publishes_pictures(self, message: Any) -> bool:
        """Return whether the sender of a message publishes the topic itself."""
        sender = connection_header(message)["callerid"]
        with self._lock:
            if sender not in self._known:
                self._known[sender] = sender in self._publishers()
            return self._known[sender]

    def forget(self) -> None:
        """Forget what is known: another recording may be played under the same name."""
        with self._lock:
            self._known.clear()

    def _publishers(self) -> Any:
        try:
            published, _subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
        except (OSError, rosgraph.MasterException) as error:
            rospy.logwarn("the ROS master does not answer: %s", error)
            return ()
        return dict(published).get(self._topic, ())


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

    A topic is advertised with its first message. A player of recordings may publish the same topics
    itself: then this node publishes nothing.
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
        self._senders = Senders("joint_states")
        self._lock = threading.Lock()  # guards everything below
        self._publishers: Dict[str, rospy.Publisher] = {}
        self._survey = SurveyPicture()
        self._description: Optional[String] = None
        self._problem: Optional[Message] = None
        self._positions = self._lines = 0
        self._subscribers = [
            rospy.Subscriber(
                "control_current_coordinate", Coordinates, self._position, queue_size=10
            ),
            rospy.Subscriber(METADATA_TOPIC, String, self._survey_description, queue_size=10),
            rospy.Subscriber(TRACE_TOPIC, rospy.AnyMsg, self._trace, queue_size=TRACE_QUEUE),
        ]
        self._diagnostics = Diagnostics(NODE, self._health)

    def _position(self, message: Coordinates) -> None:
        if self._senders.publishes_pictures(message):
            return
        positions = joint_positions(message.x_mm, message.y_mm, message.z_deg)
        if not all(math.isfinite(one) for one in positions.values()):
            return  # tf2 would report an error for each
        stamp = message.header.stamp
        with self._lock:
            if not self._positions:
                fixed = [messages.ROBOT_PLACE, *self._model.fixed()]
                self._publish("tf_static", messages.transforms(fixed, stamp))
                self._publish(DESCRIPTION, String(self._urdf))
            self._positions += 1
            self._publish("tf", messages.transforms(self._model.moving(positions), stamp))
            self._publish("joint_states", messages.joint_state(positions, stamp))
            self._publish_area(stamp)

    def _survey_description(self, message: String) -> None:
        self._senders.forget()
        with self._lock:
            # A player of recordings publishes its other topics after this one.
            self._description = message

    def _trace(self, message: rospy.AnyMsg) -> None:
        if self._senders.publishes_pictures(message):
            return
        try:
            trace = trace_message.decode(message._buff, connection_header(message)["md5sum"])
        except TraceRefusedError as error:
            rospy.logwarn("a trace cannot be shown: %s", error)
            with self._lock:
                self._problem = error.message.as_warning()
            return
        with self._lock:
            self._publish_area(ros_time(trace.timestamp_us))
            finished = self._survey.add(trace)
            if finished is not None:
                self._publish_line(finished)

    def _publish_area(self, stamp: rospy.Time) -> None:
        if self._description is None or self._senders.publishes_pictures(self._description):
            return
        area = area_of(self._description.data)
        self._description = None
        self._survey.set_area(area)
        corners = [] if area is None else area.outline()
        self._publish("survey_area", messages.outline(corners, stamp))

    def _publish_line(self, line: FinishedLine) -> None:
        stamp = ros_time(line.ended_us)
        self._lines += 1
        self._publish("b_scan", messages.image(line.picture, stamp))
        self._publish("stops", messages.stops(self._survey.stops_m, stamp))

    def _publish(self, topic: str, message: Any) -> None:
        if topic not in self._publishers:
            latch = topic in LATCHED
            self._publishers[topic] = rospy.Publisher(
                topic, TYPES[topic], queue_size=10, latch=latch
            )
        self._publishers[topic].publish(message)

    def _health(self) -> Health:
        with self._lock:
            problem, positions, lines = self._problem, self._positions, self._lines
        values = {"positions": positions, "lines": lines}
        if problem is not None:
            return WARN, problem, values
        return OK, Message("shows the robot and its survey"), values


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
