"""Subscriptions to topics of any type, for recording."""

from __future__ import annotations

from typing import Callable, Iterable

import rospy

from gpr20_vna_processing.high.messages import METADATA_TOPIC, TRACE_TOPIC
from gpr20_vna_processing.low.recording import RecordedMessage

# Topics that make an axis move or stop.
COMMANDS = ("/axis/goal", "/axis/cancel")
COMMAND_SUFFIX = "_recorded"


class TopicRecorder:
    """Hands every message of some topics on as the bytes that came."""

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
        # The storage records these two itself, exactly once.
        own = {rospy.resolve_name(TRACE_TOPIC), rospy.resolve_name(METADATA_TOPIC)}
        names = {rospy.resolve_name(topic) for topic in topics} - own
        self._subscribers = [
            rospy.Subscriber(name, rospy.AnyMsg, self._received, callback_args=recorded_name(name))
            for name in sorted(names)
        ]

    def _received(self, message: rospy.AnyMsg, topic: str) -> None:
        header = message._connection_header
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

    A recording that is played beside a robot must not move it.
    """
    return topic + COMMAND_SUFFIX if topic.endswith(COMMANDS) else topic
