"""Publishes a recorded survey on the topics of the recording."""

from __future__ import annotations

import threading
from typing import Dict, Iterable, List, Type

import rosgraph
import rospy

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.high.old_recordings import completed
from gpr20_analysis.read.replay import Content
from gpr20_common.high.raw_message import preserialized
from gpr20_common.message import Message
from gpr20_msgs.msg import Trace
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace import trace_message

TRACE_TOPIC = "trace"
QUEUE_LENGTH = 1000
POLL_S = 0.05
# All nodes publish there, also a window that shows the replay.
SHARED_TOPICS = ("/diagnostics",)


class ReplayNode:
    """Publishes messages, with a publisher for each new topic."""

    def __init__(self, stopped: threading.Event, subscriber_wait_s: float) -> None:
        """Make the replay; the ROS node must be initialized.

        Args:
            stopped: Set when the replay must end.
            subscriber_wait_s: How long a topic waits for its first subscriber before its first
                message [s].
        """
        self._stopped = stopped
        self._subscriber_wait_s = subscriber_wait_s
        self._publishers: Dict[str, rospy.Publisher] = {}
        self.published = 0
        self.traces = 0
        rospy.on_shutdown(stopped.set)

    def run(self, contents: Iterable[Content]) -> None:
        """Publish everything in the order of the iterable.

        Raises:
            AnalysisError: Another node publishes one of the topics, such as a robot, whose
                positions would be mixed with those of the recording.
        """
        for content in contents:
            if isinstance(content, RecordedMessage):
                self._publish_recorded(completed(content))
            else:
                publisher = self._publisher(rospy.resolve_name(TRACE_TOPIC), None)
                publisher.publish(preserialized(Trace, trace_message.encode(content)))
                self.traces += 1
            self.published += 1

    def _publish_recorded(self, message: RecordedMessage) -> None:
        publisher = self._publisher(message.topic, message)
        raw = publisher.data_class()
        raw._buff = message.data
        publisher.publish(raw)
        self.traces += message.datatype == trace_message.DATATYPE

    def _publisher(self, topic: str, message: object) -> rospy.Publisher:
        if topic not in self._publishers:
            if isinstance(message, RecordedMessage):
                kind, latch = _message_class(message), message.latching
            else:
                kind, latch = Trace, False
            _refuse_beside_others(topic)
            publisher = rospy.Publisher(topic, kind, latch=latch, queue_size=QUEUE_LENGTH)
            self._publishers[topic] = publisher
            if topic.rsplit("/", 1)[-1] == TRACE_TOPIC:
                self._await_subscriber(publisher)
        return self._publishers[topic]

    def _await_subscriber(self, publisher: rospy.Publisher) -> None:
        # Existing subscribers connect to a new publisher a moment later.
        polls = int(self._subscriber_wait_s / POLL_S)
        for _ in range(polls):
            if publisher.get_num_connections() or self._stopped.wait(POLL_S):
                return


def _refuse_beside_others(topic: str) -> None:
    published, _subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
    publishers: List[str] = dict(published).get(topic, [])
    others = [name for name in publishers if name != rospy.get_name()]
    if others and topic not in SHARED_TOPICS:
        raise AnalysisError(
            Message(
                "a robot or another replay is running on {address}, and its data would be mixed "
                "with those of the recording; stop it, or replay on another ROS master "
                "(ROS_MASTER_URI=http://localhost:11411 roslaunch gpr20 replay.launch survey:=...)",
                address=rosgraph.get_master_uri(),
                details=f"{topic} is published by {', '.join(others)}",
            )
        )


def _message_class(message: RecordedMessage) -> Type:
    """Return a class for messages that are sent unchanged; their type need not be installed."""
    return type(
        "RecordedAnyMsg",
        (rospy.AnyMsg,),
        {
            "__slots__": rospy.AnyMsg.__slots__,
            "_type": message.datatype,
            "_md5sum": message.md5sum,
            "_full_text": message.definition,
        },
    )
