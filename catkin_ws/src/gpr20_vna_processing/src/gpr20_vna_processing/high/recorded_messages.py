"""What is recorded of the robot's graph: topics of any type, and the last messages of a survey."""

from __future__ import annotations

import re
import time
from collections import Counter
from typing import Any, Callable, Iterable, List, Set

import rosgraph
import rospy

from gpr20_common.high.answers import message_fields
from gpr20_common.high.raw_message import connection_header, serialized
from gpr20_msgs.msg import ControlStatus
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.recording.survey_topics import OWN_TOPICS
from gpr20_survey.trace import utc_time
from gpr20_vna_processing.mid.processing_records import OUTCOMES, SurveyEnd

# Topics that make an axis move or stop have another name in the recording: playing it on the master
# of a robot must not move the robot.
COMMANDS = ("/axis/goal", "/axis/cancel")
COMMAND_SUFFIX = "_recorded"
# Connections to nodes that were just started are made within this time [s].
CONNECTION_LIMIT_S = 2.0
POLL_S = 0.02
# As `rosbag play` names itself: what it plays on the topics of the robot is another recording.
PLAYER = re.compile(r"play_\d+")
STATUS_TOPIC = "control_status"
# A coverage with a reason for each of the most samples that a survey may have is smaller.
LARGEST_BYTES = 16 << 20


class TopicRecorder:
    """Passes every message of some topics on as the bytes that came, but those of a player."""

    def __init__(self, topics: Iterable[str], record: Callable[[RecordedMessage], None]) -> None:
        """Subscribe to topics, relative to the node's namespace or absolute."""
        self._record = record
        self._players: Set[str] = set()
        # The storage records these itself, exactly once.
        own = {rospy.resolve_name(name) for name in OWN_TOPICS}
        names = {rospy.resolve_name(topic) for topic in topics} - own
        recorded = {one: one + COMMAND_SUFFIX * one.endswith(COMMANDS) for one in sorted(names)}
        self._subscribers = [
            rospy.Subscriber(name, rospy.AnyMsg, self._received, callback_args=recorded[name])
            for name in recorded
        ]

    def unconnected(self) -> List[str]:
        """Return the topics of which a publisher that the master knows is not connected yet.

        What it sends before is in no recording. MasterException, OSError: the master is away.
        """
        published, _subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
        publishers = Counter({topic: len(nodes) for topic, nodes in published})
        return [
            one.name
            for one in self._subscribers
            if one.get_num_connections() < publishers[one.name]
        ]

    def _received(self, message: rospy.AnyMsg, topic: str) -> None:
        header = connection_header(message)
        sender = header["callerid"]
        if PLAYER.fullmatch(sender.rpartition("/")[2]):
            if sender not in self._players:
                self._players.add(sender)
                rospy.logwarn("%s plays another recording; its messages are not recorded", sender)
            return
        self._record(
            RecordedMessage(
                topic=topic,
                datatype=header["type"],
                md5sum=header["md5sum"],
                definition=header["message_definition"],
                data=message._buff,
                time_ns=time.time_ns(),
                latching=header.get("latching") == "1",
            )
        )


def wait_for_nodes(unconnected: Callable[[], List[str]], warning: str) -> None:
    """Wait until no topic lacks the connection to a node, or the time is over; it may be dead.

    The master, which is asked, may be away: storing does not depend on it, and missing positions do
    not refuse a survey.
    """
    deadline_s = time.monotonic() + CONNECTION_LIMIT_S
    try:
        missing = unconnected()
        while missing and time.monotonic() <= deadline_s:
            time.sleep(POLL_S)
            missing = unconnected()
        if missing:
            rospy.logwarn(warning, ", ".join(missing))
    except (rosgraph.MasterException, OSError) as error:
        rospy.logwarn("the master did not list the nodes of a topic: %s", error)


def end_messages(request: Any, time_ns: int) -> List[RecordedMessage]:
    """Return the last messages that a request to close a survey holds, the status last.

    There are none if the status is of another survey or states another outcome: then the storage
    states the end.
    """
    status = request.status
    _sentence, states = OUTCOMES.get(request.outcome, ("", ()))
    if status.survey_id != request.survey_id or status.code not in states:
        return []
    given = (
        ("control_survey_data", request.progress, False),
        ("survey_coverage", request.coverage, True),
        (STATUS_TOPIC, status, True),
    )
    messages = [
        _recorded(topic, message, time_ns, latching)
        for topic, message, latching in given
        if message.survey_id == request.survey_id
    ]
    return [one for one in messages if len(one.data) <= LARGEST_BYTES]


def end_status(end: SurveyEnd) -> RecordedMessage:
    """Return the last status of a survey whose end only the storage knows."""
    status = ControlStatus(**message_fields(end.message))
    status.header.stamp = rospy.Time(*divmod(end.time_ns, utc_time.NS_PER_S))
    status.code = status.end = int(end.state)
    status.ended = status.header.stamp
    status.survey_id = end.survey_id
    status.simulated = end.simulated
    return _recorded(STATUS_TOPIC, status, end.time_ns, latching=True)


def _recorded(topic: str, message: Any, time_ns: int, latching: bool) -> RecordedMessage:
    return RecordedMessage(
        rospy.resolve_name(topic),
        message._type,
        message._md5sum,
        message._full_text,
        serialized(message),
        time_ns,
        latching,
    )
