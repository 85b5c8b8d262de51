"""What a node says about itself: its hardware, its software, the configuration of its start.

The configuration is shown on the parameter server as well, under the node's own name:
`rosparam get /x_axis/axis_driver/max_step`. It is shown, not read: changing it changes nothing.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
from typing import Any, Mapping

import rosgraph
import rospy

from gpr20_common.high.node import configuration_name
from gpr20_common.low.links import NO_ANSWER, limited_server, value_of
from gpr20_common.mid.codec import plain
from gpr20_common.mid.node_facts import Hardware, own_software
from gpr20_msgs.msg import NodeDescription

TOPIC = "description"
# The master answers within this time, or is gone [s].
ANSWER_LIMIT_S = 1.0
# XML-RPC has no larger ones.
LARGEST_INT = 2**31 - 1


def publish_description(node: str, hardware: Hardware, parameters: Any) -> rospy.Publisher:
    """Publish, latched, what a node below the robot's namespace is; the publisher must be kept."""
    values = plain(parameters)
    show_parameters(values)
    publisher = rospy.Publisher(f"~{TOPIC}", NodeDescription, queue_size=1, latch=True)
    publisher.publish(
        NodeDescription(
            node=node,
            hardware=hardware.name,
            simulated=hardware.simulated,
            time_scale=hardware.time_scale,
            configuration_json=json.dumps(values),
            **dataclasses.asdict(own_software()),
        )
    )
    return publisher


def show_parameters(values: Mapping[str, Any]) -> None:
    """Show the parameters of this node until it ends.

    One that was started alone refuses private parameters: it would take its own for such.
    """
    if not configuration_name():
        return
    master = limited_server(rosgraph.get_master_uri(), ANSWER_LIMIT_S)
    name = rospy.get_name()

    def remove() -> None:
        with contextlib.suppress(*NO_ANSWER):  # with the master they are gone
            master.deleteParam(name, name)

    rospy.on_shutdown(remove)
    try:
        value_of(master.setParam(name, name, shown(plain(values))))
    except NO_ANSWER as error:
        rospy.logwarn("the parameters cannot be shown: %s", error)


def shown(value: Any) -> Any:
    """Return a value of JSON as the parameter server can hold it; None is an empty text."""
    if value is None:
        return ""
    if isinstance(value, dict):
        return {key: shown(one) for key, one in value.items()}
    if isinstance(value, list):
        return [shown(one) for one in value]
    if isinstance(value, int) and abs(value) > LARGEST_INT:
        return float(value)
    if isinstance(value, str) and not value.isprintable():
        return json.dumps(value)
    return value
