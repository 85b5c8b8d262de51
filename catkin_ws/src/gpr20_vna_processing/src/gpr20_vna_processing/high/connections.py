"""Waiting for the other nodes of a topic, which connect some time after this one has started."""

from __future__ import annotations

import time
from typing import Callable

import rosgraph
import rospy

from gpr20_common.high.subscribers import subscriber_count
from gpr20_vna_processing.high.topic_recorder import TopicRecorder

# Connections to nodes that were just started are made within this time [s].
CONNECTION_LIMIT_S = 2.0
POLL_S = 0.02


def connect_recorder(recorder: TopicRecorder) -> None:
    """Wait until every publisher of the recorded topics is connected, or the time is over."""

    def connect() -> None:
        missing = recorder.wait_until_connected(CONNECTION_LIMIT_S)
        if missing:
            rospy.logwarn("recording begins without a publisher of %s", ", ".join(missing))

    _unless_the_master_is_away(connect)


def connect_subscribers(publisher: rospy.Publisher) -> None:
    """Wait until every subscriber of a topic is connected, or the time is over.

    What is published before reaches none of them.
    """

    def connect() -> None:
        deadline_s = time.monotonic() + CONNECTION_LIMIT_S
        topic = publisher.resolved_name
        while publisher.get_num_connections() < subscriber_count(topic):
            if time.monotonic() > deadline_s:
                rospy.logwarn("a subscriber of %s is not connected", topic)
                return
            time.sleep(POLL_S)

    _unless_the_master_is_away(connect)


def _unless_the_master_is_away(connect: Callable[[], None]) -> None:
    try:
        connect()
    except (rosgraph.MasterException, OSError) as error:
        # Storing does not depend on the master; missing positions do not refuse a survey.
        rospy.logwarn("the master did not list the nodes of a topic: %s", error)
