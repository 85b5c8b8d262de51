"""What nodes report on the graph, as the records of the lower levels."""

from __future__ import annotations

from typing import Any, Dict, List

from diagnostic_msgs.msg import DiagnosticArray

from gpr20_common.high.diagnostics import MESSAGE_JSON
from gpr20_common.message import received_message
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_msgs.msg import RobotConfiguration
from gpr20_survey.plan.robot_description import NodeDescription


def node_healths(message: DiagnosticArray, namespace: str) -> List[NodeHealth]:
    """Convert the reports on `/diagnostics` of the nodes of one namespace.

    Args:
        message: Of any nodes; robots that share a master share the topic.
        namespace: The robot's, with slashes at both ends or alone.
    """
    prefix = namespace.strip("/")
    found = []
    for status in message.status:
        # diagnostic_updater writes "node: task", with the node's full name.
        name = status.name.split(":")[0].strip("/")
        if prefix and not name.startswith(f"{prefix}/"):
            continue
        values = {pair.key: pair.value for pair in status.values}
        level = HealthLevel(_level_number(status.level))
        own_name = name[len(prefix) :].strip("/")
        text = received_message(status.message, values.pop(MESSAGE_JSON, ""))
        found.append(NodeHealth(own_name, level, text, values))
    return found


def descriptions(message: RobotConfiguration) -> Dict[str, NodeDescription]:
    """Return what the nodes say they are; a node that says nonsense is left out."""
    found = {}
    for one in message.nodes:
        try:
            found[one.node] = NodeDescription.from_fields(one)
        except ValueError:
            continue  # the main control reports it as a problem of the configuration
    return found


def _level_number(level: Any) -> int:
    # The type byte is an int in ROS 1's Python messages, and bytes in some builds of them.
    return level[0] if isinstance(level, bytes) else int(level)
