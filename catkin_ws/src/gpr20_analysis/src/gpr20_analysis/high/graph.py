"""Who else is on the ROS graph."""

from __future__ import annotations

from typing import Iterable, List

import rosgraph

from gpr20_analysis.errors import AnalysisError
from gpr20_common.message import Message

# Topics that are not a robot's alone: every node publishes its health, and the log node of each
# master, which collects the log of the replay too, publishes the collected log.
SHARED_TOPICS = ("/diagnostics", "/rosout_agg")
CALLER = "/replay"


def refuse_beside_others(topics: Iterable[str], own_name: str = "") -> None:
    """Refuse to publish on topics that another node publishes.

    Args:
        topics: Absolute names.
        own_name: Name of this node; empty before it has joined the graph.

    Raises:
        AnalysisError: A robot or another replay publishes one of them.
    """
    published, _subscribed, _services = rosgraph.Master(CALLER).getSystemState()
    for topic, publishers in published:
        others: List[str] = [name for name in publishers if name != own_name]
        if others and topic in set(topics) - set(SHARED_TOPICS):
            raise AnalysisError(
                Message(
                    "a robot or another replay is running on {address}, and its data would be "
                    "mixed with those of the recording; stop it, or replay on another ROS master "
                    "(ROS_MASTER_URI=http://localhost:11411 roslaunch gpr20 replay.launch "
                    "survey:=...)",
                    address=rosgraph.get_master_uri(),
                    details=f"{topic} is published by {', '.join(others)}",
                )
            )


def subscriber_count(topic: str) -> int:
    """Return how many nodes subscribe to a topic, by the master."""
    _published, subscribed, _services = rosgraph.Master(CALLER).getSystemState()
    return len(dict(subscribed).get(topic, ()))
