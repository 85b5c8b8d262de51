"""What nodes and other sensors say of themselves: their topics, and what is made of it."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import Any, Callable, List, Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.high.answers import message_fields
from gpr20_common.high.diagnostics import FAULT, PERIOD_S
from gpr20_common.high.node import DESCRIPTION
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.raw_message import connection_header
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_main_control.high.message_field import MessageField
from gpr20_main_control.mid.devices.described_robot import (
    AuxSensors,
    DescribedRobot,
    Measured,
    SensorInput,
)
from gpr20_msgs.msg import NodeDescription as NodeDescriptionMessage
from gpr20_msgs.msg import RobotConfiguration
from gpr20_survey.plan.robot_description import (
    PLAIN_NAMES,
    SIMULATOR,
    STORAGE,
    NodeDescription,
)
from gpr20_survey.plan.sensors import Sensor

DESCRIBED_NODES = (*PLAIN_NAMES, STORAGE, SIMULATOR)
# Below the robot's namespace, as the names of its nodes.
STATUS_FOLDER = "sensors"


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
                rospy.Subscriber(f"{node}/{DESCRIPTION}", NodeDescriptionMessage, receive)
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


def field_of(sensor: Sensor) -> MessageField:
    """Return the field that holds the value of a sensor.

    Raises:
        InvalidValueError: Its type or field does not exist; the message names sensor and topic.
    """
    try:
        return MessageField(sensor.message, sensor.field)
    except InvalidValueError as error:
        raise InvalidValueError(
            Message(
                "sensors.yaml, sensor {sensor} on the topic {topic}: {reason}",
                sensor=sensor.name,
                topic=sensor.topic,
                reason=error.message,
            ),
            fault=CONFIGURATION,
        ) from error


class SensorTopics:
    """Subscribes to the sensors and reports their health once a second."""

    def __init__(self, sensors: Sequence[Sensor], clock: Clock) -> None:
        """Subscribe.

        Raises:
            InvalidValueError: The type or the field of a sensor does not exist.
        """
        inputs = [SensorInput(one, field_of(one).read, clock) for one in sensors]
        self.sensors = AuxSensors(inputs, clock)
        # As bytes: a type of another name arrives too, and no message is read without need.
        self._subscribers = [
            rospy.Subscriber(one.sensor.topic, rospy.AnyMsg, one.note, queue_size=1)
            for one in inputs
        ]
        if inputs:
            self._publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=1)
            self._periodic = Periodic(PERIOD_S, self._report)

    def _report(self) -> None:
        message = DiagnosticArray(status=[_status(one) for one in self.sensors.now()])
        message.header.stamp = rospy.Time.now()
        self._publisher.publish(message)


def _status(measured: Measured) -> DiagnosticStatus:
    sensor, message = measured.sensor, measured.message
    level = DiagnosticStatus.OK
    if measured.problem is not None:
        level = DiagnosticStatus.ERROR if sensor.required else DiagnosticStatus.WARN
        message = message if sensor.required else message.as_warning()
    values = {
        FAULT: message.to_json(),
        "value": "" if measured.value is None else repr(measured.value),
        "unit": sensor.unit,
        "age [s]": "" if measured.age_s is None else f"{measured.age_s:.1f}",
        "topic": rospy.resolve_name(sensor.topic),
    }
    pairs: List[KeyValue] = [KeyValue(key, value) for key, value in values.items()]
    name = rospy.resolve_name(f"{STATUS_FOLDER}/{sensor.name}").strip("/")
    return DiagnosticStatus(level, f"{name}: value", str(message), "", pairs)
