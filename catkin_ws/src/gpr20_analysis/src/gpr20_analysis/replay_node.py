"""Publishes a recorded survey in the namespace of the replay, which can be paused."""

from __future__ import annotations

import dataclasses
import io
from typing import Any, Dict, Iterable, Type

import genpy
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray

from gpr20_analysis import errors
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.replay import Playback, ReplayedSurvey
from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.high.answers import advertise, message_fields
from gpr20_common.high.graph_keeper import subscriber_count
from gpr20_common.high.periodic import Periodic
from gpr20_common.low.clock import Clock
from gpr20_common.low.links import NodeProbe
from gpr20_common.message import Message
from gpr20_msgs.msg import Replay
from gpr20_msgs.srv import Command, CommandResponse, SetReplayRate, SetReplayRateResponse
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.recording.survey_topics import METADATA_TOPIC, REPLAY_TOPIC, TRACE_TOPIC
from gpr20_survey.trace import trace_message

QUEUE_LENGTH = 1000
PERIOD_S = 0.5
POLL_S = 0.05
# A subscriber that is known to the master may be dead [s].
CONNECT_WAIT_S = 2.0
# Without a subscriber a trace waits this long for a first one [s].
FIRST_WAIT_S = 2.0
# For the last messages to be sent [s].
LINGER_S = 0.5
TOPICS_OF_A_ROBOT = ("control_status", TRACE_TOPIC, METADATA_TOPIC, REPLAY_TOPIC)
# Topics that are not a robot's alone: every node publishes its health, and the log node of each
# master, which collects the log of the replay too, publishes the collected log.
SHARED_TOPICS = ("/diagnostics", "/rosout_agg")
CALLER = "/replay"
# A node that lives answers within this time [s].
ANSWER_LIMIT_S = 1.0


def refuse_beside_others(topics: Iterable[str], own_name: str = "") -> None:
    """Refuse to publish on topics that another node publishes.

    Args:
        topics: Absolute names.
        own_name: Name of this node; empty before it has joined the graph.

    Raises:
        AnalysisError: A robot or another replay publishes one of them, or there is no master.
    """
    if not rosgraph.is_master_online():
        raise AnalysisError(
            Message(
                "no ROS master answers at {address}; start roscore, or use roslaunch gpr20 "
                "replay.launch",
                address=rosgraph.get_master_uri(),
            ),
            fault=errors.NO_ROS,
        )
    published, _subscribed, _services = rosgraph.Master(CALLER).getSystemState()
    publishers_of = dict(published)
    for topic in topics:
        if topic in SHARED_TOPICS:
            continue
        others = [name for name in publishers_of.get(topic, ()) if name != own_name]
        # The master still lists a node that was killed.
        others = [name for name in others if not _is_gone(name)]
        if others:
            raise AnalysisError(
                Message(
                    "a robot or another replay uses these topics, and its data would be mixed "
                    "with those of the recording; end it, or replay in another namespace "
                    "(roslaunch gpr20 replay.launch ns:=replay2 survey:=...)",
                    details=f"{topic} is published by {', '.join(others)}",
                ),
                fault=errors.ROBOT_RUNS,
            )


def _is_gone(node: str) -> bool:
    try:
        NodeProbe(rosgraph.get_master_uri(), CALLER, node, ANSWER_LIMIT_S).process()
    except (NodeGoneError, NodeSilentError) as error:
        return isinstance(error, NodeGoneError)
    return False


class ReplayNode:
    """Publishes messages, with a publisher for each new topic, and says that it is a replay.

    The latched topic `replay` says so, and services beside it pause, continue and change the rate.
    The ROS node must be initialized.

    Args:
        playback: Gives out the messages.
        replayed: The survey.
        namespace: In which it is published, absolute, with a slash at its end.

    Attributes:
        traces: Number of traces that were published.
    """

    def __init__(self, playback: Playback, replayed: ReplayedSurvey, namespace: str) -> None:
        self._playback = playback
        self._replayed = replayed
        self._namespace = namespace
        self._clock = Clock()
        self._publishers: Dict[str, rospy.Publisher] = {}
        self.traces = 0
        self._ended = False
        self._marker = rospy.Publisher(
            f"{namespace}{REPLAY_TOPIC}", Replay, latch=True, queue_size=10
        )
        self._services = [
            advertise(f"{namespace}pause", Command, lambda _: self._set_paused(True)),
            advertise(f"{namespace}continue", Command, lambda _: self._set_paused(False)),
            advertise(f"{namespace}set_rate", SetReplayRate, self._set_rate),
        ]
        self._periodic = Periodic(PERIOD_S, self._say_state)

    def run(self, messages: Iterable[RecordedMessage], window_wait_s: float) -> None:
        """Publish everything in the order of the iterable.

        Args:
            messages: The recording.
            window_wait_s: How long to wait for a window before the first message [s].

        Raises:
            AnalysisError: Another node publishes one of the topics, such as a robot, whose
                positions would be mixed with those of the recording.
        """
        # Before any other message: nobody must take those for a robot's.
        self._await_subscribers(self._marker, window_wait_s)
        for message in self._playback.play(messages):
            self._publish(message)
        # Messages are sent by other threads, which end with the node.
        self._clock.wait_s(self._playback.ended, LINGER_S)
        if not self._playback.stopped:
            self._periodic.stop()
            self._ended = True
            self._say_state()

    def _publish(self, recorded: RecordedMessage) -> None:
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
            # A fast replay publishes traces faster than they are sent: none is dropped.
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

    def _set_paused(self, paused: bool) -> CommandResponse:
        self._playback.set_paused(paused)
        self._say_state()
        said = Message("The replay is paused.")
        said = said if paused else Message("The replay continues.")
        return CommandResponse(success=True, **message_fields(said))

    def _set_rate(self, request: Any) -> SetReplayRateResponse:
        self._playback.set_rate(request.rate)
        self._say_state()
        said = Message("The replay runs {rate:g} times as fast.", rate=request.rate)
        return SetReplayRateResponse(success=True, **message_fields(said))

    def _say_state(self) -> None:
        survey, playback = self._replayed, self._playback
        state = Replay.PAUSED if playback.paused else Replay.PLAYING
        self._marker.publish(
            Replay(
                survey_id=survey.survey_id,
                started=survey.started,
                folder=survey.folder,
                state=Replay.ENDED if self._ended else state,
                rate=playback.rate,
                position_s=playback.position_s,
                length_s=survey.length_s,
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
