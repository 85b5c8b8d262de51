"""Who else publishes on the ROS graph."""

from __future__ import annotations

from typing import Iterable

import rosgraph

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.low.links import NodeProbe
from gpr20_common.message import Message

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
        AnalysisError: A robot or another replay publishes one of them.
    """
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
                fault=faults.ROBOT_RUNS,
            )


def _is_gone(node: str) -> bool:
    try:
        NodeProbe(rosgraph.get_master_uri(), CALLER, node, ANSWER_LIMIT_S).process()
    except NodeGoneError:
        return True
    except NodeSilentError:
        return False
    return False
