"""Subscriptions to topics of any type, for recording."""

from __future__ import annotations

import re
import time
from collections import Counter
from typing import Callable, Iterable, List, Set

import rosgraph
import rospy

from gpr20_common.high.connection_header import connection_header
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.replay_message import REPLAY_TOPIC
from gpr20_survey.recording.survey_topics import LOG_TOPIC, METADATA_TOPIC, TRACE_TOPIC

# Topics that make an axis move or stop.
COMMANDS = ("/axis/goal", "/axis/cancel")
COMMAND_SUFFIX = "_recorded"
POLL_S = 0.02
# As `rosbag play` names itself: what it plays on the topics of the robot is another recording.
PLAYER = re.compile(r"play_\d+")


class TopicRecorder:
    """Passes every message of some topics on as the bytes that came, but those of a player."""

    def __init__(
        self,
        topics: Iterable[str],
        record: Callable[[RecordedMessage], None],
        now_ns: Callable[[], int],
    ) -> None:
        """Subscribe.

        Args:
            topics: Names, relative to the node's namespace or absolute.
            record: Takes each message; must not wait.
            now_ns: Time of day [ns since 1970, UTC].
        """
        self._record = record
        self._now_ns = now_ns
        self._players: Set[str] = set()
        # The storage records these itself, exactly once.
        stored = (TRACE_TOPIC, METADATA_TOPIC, LOG_TOPIC, REPLAY_TOPIC)
        own = {rospy.resolve_name(name) for name in stored}
        names = {rospy.resolve_name(topic) for topic in topics} - own
        self._subscribers = [
            rospy.Subscriber(name, rospy.AnyMsg, self._received, callback_args=recorded_name(name))
            for name in sorted(names)
        ]

    def wait_until_connected(self, limit_s: float) -> List[str]:
        """Wait until every publisher of the topics that the master knows is connected.

        What a publisher sends before is in no recording.

        Args:
            limit_s: Longest wait [s].

        Returns:
            The topics that still lack a publisher; its node may be dead.
        """
        deadline_s = time.monotonic() + limit_s
        while True:
            publishers = self._publishers()
            missing = [
                one.name
                for one in self._subscribers
                if one.get_num_connections() < publishers[one.name]
            ]
            if not missing or time.monotonic() > deadline_s:
                return missing
            time.sleep(POLL_S)

    def _publishers(self) -> Counter[str]:
        published, _subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
        return Counter({topic: len(nodes) for topic, nodes in published})

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
                time_ns=self._now_ns(),
                latching=header.get("latching") == "1",
            )
        )


def recorded_name(topic: str) -> str:
    """Return the name under which a topic is recorded: its own, unless it commands an axis.

    Playing a recording on the master of a robot must not move the robot.
    """
    return topic + COMMAND_SUFFIX if topic.endswith(COMMANDS) else topic
