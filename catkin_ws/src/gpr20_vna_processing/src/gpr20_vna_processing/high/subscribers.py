"""Waiting for the subscribers of a topic."""

from __future__ import annotations

import time

import rosgraph
import rospy

POLL_S = 0.02


def wait_for_subscribers(publisher: rospy.Publisher, limit_s: float) -> bool:
    """Wait until every subscriber of a topic that the master knows is connected.

    A node that has just started is not connected to its subscribers yet, and what it publishes
    before reaches none of them.

    Args:
        publisher: Publishes the topic.
        limit_s: Longest wait [s]; the node of a subscriber may be dead.

    Returns:
        Whether all are connected.

    Raises:
        OSError: The master does not answer.
        rosgraph.MasterException: Its answer makes no sense.
    """
    deadline_s = time.monotonic() + limit_s
    while publisher.get_num_connections() < _subscribers(publisher.resolved_name):
        if time.monotonic() > deadline_s:
            return False
        time.sleep(POLL_S)
    return True


def _subscribers(topic: str) -> int:
    _published, subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
    return len(dict(subscribed).get(topic, []))
