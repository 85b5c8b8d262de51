"""What a node says about itself: its hardware, its software, the configuration of its start.

The configuration is shown on the parameter server as well.
"""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import rospy

from gpr20_common.high.shown_parameters import show_parameters
from gpr20_common.mid.codec import plain
from gpr20_common.mid.hardware import Hardware
from gpr20_common.mid.node_software import own_software
from gpr20_msgs.msg import NodeDescription

TOPIC = "description"


def publish_description(node: str, hardware: Hardware, parameters: Any) -> rospy.Publisher:
    """Publish, latched, what this node is; the publisher must be kept.

    Args:
        node: Name of this node below the robot's namespace, such as x_axis/axis_driver.
        hardware: What it drives.
        parameters: Dataclass of the parameters with which it started.
    """
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
