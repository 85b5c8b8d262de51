"""The subscribers of a topic, which connect some time after its publisher has started."""

from __future__ import annotations

import rosgraph
import rospy


def subscriber_count(topic: str) -> int:
    """Return how many nodes subscribe to a topic, by the master.

    Args:
        topic: Absolute name.

    Raises:
        rosgraph.MasterException: The master refuses to answer.
        OSError: The master does not answer.
    """
    _published, subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
    return len(dict(subscribed).get(topic, ()))
