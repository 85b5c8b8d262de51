"""Subscriptions to topics of any type, for recording."""

from __future__ import annotations

from typing import Callable, Iterable

import rospy

from gpr20_vna_processing.high.messages import METADATA_TOPIC, TRACE_TOPIC
from gpr20_vna_processing.low.recording import RecordedMessage


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
            rospy.Subscriber(name, rospy.AnyMsg, self._received, callback_args=name)
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
