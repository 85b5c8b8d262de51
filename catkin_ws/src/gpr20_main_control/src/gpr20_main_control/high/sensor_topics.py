"""Other sensors beside the radar: their topics, and what they report on /diagnostics."""

from __future__ import annotations

from typing import List, Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.high.diagnostics import FAULT, PERIOD_S
from gpr20_common.high.periodic import Periodic
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_main_control.high.message_field import MessageField
from gpr20_main_control.mid.devices.aux_sensors import AuxSensors, Measured, SensorInput
from gpr20_survey.plan.sensors import Sensor

# Below the robot's namespace, as the names of its nodes.
STATUS_FOLDER = "sensors"


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
