"""The descriptions of the nodes, and what they say together."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import Any, Callable, List

import rospy

from gpr20_common.high.answers import message_fields
from gpr20_common.high.description import TOPIC
from gpr20_common.high.raw_message import connection_header
from gpr20_main_control.mid.devices.described_robot import DescribedRobot
from gpr20_msgs.msg import NodeDescription as NodeDescriptionMessage
from gpr20_msgs.msg import RobotConfiguration
from gpr20_survey.plan.robot_description import (
    PLAIN_NAMES,
    SIMULATOR,
    STORAGE,
    NodeDescription,
)

DESCRIBED_NODES = (*PLAIN_NAMES, STORAGE, SIMULATOR)


class DescriptionTopics:
    """Follows the topic `description` of each node; publishes `robot_configuration`, latched."""

    def __init__(self) -> None:
        self._subscribers: List[rospy.Subscriber] = []
        self._publisher = rospy.Publisher(
            "robot_configuration", RobotConfiguration, queue_size=1, latch=True
        )

    def listen(self, note: Callable[[NodeDescription], None]) -> None:
        """Call `note` with the description of each node, now and whenever it starts again."""
        for node in DESCRIBED_NODES:
            full_name = rospy.resolve_name(node)

            def receive(message: Any, node: str = node, full_name: str = full_name) -> None:
                # What another node publishes, such as a recording, says nothing about this one.
                if connection_header(message).get("callerid") == full_name:
                    note(replace(NodeDescription.from_fields(message), node=node))

            self._subscribers.append(
                rospy.Subscriber(f"{node}/{TOPIC}", NodeDescriptionMessage, receive)
            )

    def publish(self, robot: DescribedRobot) -> None:
        """Publish what the nodes say together."""
        problem = robot.problem()
        message = RobotConfiguration(
            known=problem is None,
            simulated=problem is None and robot.config().simulated,
            nodes=[
                NodeDescriptionMessage(**one.fields()) for _name, one in sorted(robot.nodes.items())
            ],
            site_json=json.dumps(asdict(robot.site)),
            **({} if problem is None else message_fields(problem)),
        )
        message.header.stamp = rospy.Time.now()
        self._publisher.publish(message)
