"""Publishes a recorded survey in the namespace of the replay."""

from __future__ import annotations

import dataclasses
import io
from typing import Dict, Iterable, Type

import genpy
import rospy
from diagnostic_msgs.msg import DiagnosticArray

from gpr20_analysis.high.graph import refuse_beside_others
from gpr20_analysis.high.replay_marker import ReplayMarker
from gpr20_analysis.read.playback import Playback
from gpr20_analysis.read.replay import Due, ReplayedSurvey
from gpr20_common.high.graph_keeper import subscriber_count
from gpr20_common.high.raw_message import preserialized
from gpr20_common.low.clock import Clock
from gpr20_msgs.msg import Trace
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.recording.survey_topics import TRACE_TOPIC
from gpr20_survey.trace import trace_message

QUEUE_LENGTH = 1000
POLL_S = 0.05
# A subscriber that is known to the master may be dead [s].
CONNECT_WAIT_S = 2.0
# Without a subscriber a trace waits this long for a first one [s].
FIRST_WAIT_S = 2.0
# For the last messages to be sent [s].
LINGER_S = 0.5


class ReplayNode:
    """Publishes messages, with a publisher for each new topic."""

    def __init__(
        self,
        playback: Playback,
        marker: ReplayMarker,
        replayed: ReplayedSurvey,
        namespace: str,
        window_wait_s: float,
    ) -> None:
        """Make the replay; the ROS node must be initialized.

        Args:
            playback: Gives out the messages.
            marker: Says that this is a replay.
            replayed: The survey.
            namespace: In which it is published, absolute, with a slash at its end.
            window_wait_s: How long to wait for a window before the first message [s].
        """
        self._playback = playback
        self._marker = marker
        self._replayed = replayed
        self._namespace = namespace
        self._window_wait_s = window_wait_s
        self._clock = Clock()
        self._publishers: Dict[str, rospy.Publisher] = {}
        self.published = 0
        self.traces = 0

    def run(self, items: Iterable[Due]) -> None:
        """Publish everything in the order of the iterable.

        Raises:
            AnalysisError: Another node publishes one of the topics, such as a robot, whose
                positions would be mixed with those of the recording.
        """
        # Before any other message: nobody must take those for a robot's.
        self._await_subscribers(self._marker.publisher, self._window_wait_s)
        for content in self._playback.play(items):
            if isinstance(content, RecordedMessage):
                self._publish_recorded(content)
            else:
                publisher = self._publisher(f"{self._namespace}{TRACE_TOPIC}", Trace, False)
                publisher.publish(preserialized(Trace, trace_message.encode(content)))
                self.traces += 1
            self.published += 1
        # Messages are sent by other threads, which end with the node.
        self._clock.wait_s(self._playback.ended, LINGER_S)

    def _publish_recorded(self, recorded: RecordedMessage) -> None:
        is_report = recorded.datatype == DiagnosticArray._type
        message = self._own_reports(recorded) if is_report else recorded
        topic = self._replayed.name_in(self._namespace, message.topic)
        publisher = self._publisher(topic, _message_class(message), message.latching)
        raw = publisher.data_class()
        raw._buff = message.data
        publisher.publish(raw)
        self.traces += message.datatype == trace_message.DATATYPE

    def _own_reports(self, message: RecordedMessage) -> RecordedMessage:
        """Return the reports of the recorded robot, by the names of its nodes in the replay.

        All robots of a master share the topic.
        """
        reports = DiagnosticArray()
        try:
            reports.deserialize(message.data)
        except genpy.DeserializationError:
            return message  # no subscriber can read it, and the replay continues
        own = []
        for status in reports.status:
            name = f"/{status.name.lstrip('/')}"
            if name.startswith(self._replayed.namespace):
                status.name = self._replayed.name_in(self._namespace, name)
                own.append(status)
        reports.status = own
        data = io.BytesIO()
        reports.serialize(data)
        return dataclasses.replace(message, data=data.getvalue())

    def _publisher(self, topic: str, kind: Type, latch: bool) -> rospy.Publisher:
        if topic not in self._publishers:
            refuse_beside_others([topic], rospy.get_name())
            is_trace = topic.rsplit("/", 1)[-1] == TRACE_TOPIC
            # A replay from a later start publishes all traces before it at once: none is dropped.
            size = 0 if latch or is_trace else QUEUE_LENGTH
            publisher = rospy.Publisher(topic, kind, latch=latch, queue_size=size)
            self._publishers[topic] = publisher
            # No subscriber must miss a message, however short the replay is.
            self._await_subscribers(publisher, FIRST_WAIT_S if is_trace else 0.0)
        return self._publishers[topic]

    def _await_subscribers(self, publisher: rospy.Publisher, first_wait_s: float) -> None:
        """Wait until the subscribers have connected, which takes them a moment.

        Args:
            publisher: Of a new topic.
            first_wait_s: How long to wait for a first one, if there is none yet [s].
        """
        begin_s = self._clock.now_s()
        while not self._playback.stopped:
            waited_s = self._clock.now_s() - begin_s
            known, connected = subscriber_count(publisher.name), publisher.get_num_connections()
            if waited_s >= (CONNECT_WAIT_S if known else first_wait_s):
                return
            if known and connected >= known:
                return
            self._clock.wait_s(self._playback.ended, POLL_S)


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
