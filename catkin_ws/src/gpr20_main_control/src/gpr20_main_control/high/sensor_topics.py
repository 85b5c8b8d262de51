"""Other sensors over ROS: their topics, their health, one number inside messages of any type."""

from __future__ import annotations

import math
import re
from typing import Any, Dict, List, Optional, Sequence, Tuple

import roslib.message
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.high.diagnostics import FAULT, PERIOD_S
from gpr20_common.high.periodic import Periodic
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_main_control.mid.devices.described_robot import AuxSensors, Measured, SensorInput
from gpr20_survey.plan.robot_description import Sensor

# Below the robot's namespace, as the names of its nodes.
STATUS_FOLDER = "sensors"
_NUMBER = re.compile("bool|u?int(8|16|32|64)|float(32|64)")


class MessageField:
    """Reads one number from messages of a type.

    Attributes:
        message_class: The class of these messages.
    """

    def __init__(self, datatype: str, path: str) -> None:
        """Find the field, such as `data` or `a.b[0]`, in a type such as `std_msgs/Float64`.

        Raises:
            InvalidValueError: The type is not installed here, or has no such number; the message
                names its fields.
        """
        reason: object = ""
        try:
            self.message_class = roslib.message.get_message_class(datatype)
        except (ValueError, ImportError) as error:
            self.message_class, reason = None, error
        if self.message_class is None:
            raise InvalidValueError(
                Message(
                    "the message type {type} is not installed here; check its name, or install "
                    "its package",
                    type=datatype,
                    details=reason,
                ),
                fault=CONFIGURATION,
            )
        # A name, and the index in a list.
        self._steps: List[Tuple[str, Optional[int]]] = []
        fields = _fields(datatype)
        for part in path.split("."):
            name, has_index, index = part.partition("[")
            kind, is_list, _length = fields.get(name, "").partition("[")
            if not kind or has_index != is_list:
                break
            self._steps.append((name, int(index[:-1]) if has_index else None))
            fields = _fields(kind) or fields
        else:
            if _NUMBER.fullmatch(kind):
                return
        raise InvalidValueError(
            Message(
                "{type} has no number {field}; its fields are: {fields}; one value of a list is "
                "written with its index, such as {example}",
                type=datatype,
                field=path,
                fields=", ".join(f"{name} ({one})" for name, one in fields.items()),
                example="data[0]",
            ),
            fault=CONFIGURATION,
        )

    def read(self, message: Any) -> float:
        """Return the number in a message; NaN if its list is too short."""
        value = message
        for name, index in self._steps:
            value = getattr(value, name)
            if index is not None:
                value = value[index] if index < len(value) else math.nan
        return float(value)


class SensorTopics:
    """Subscribes to the sensors and reports their health once a second."""

    def __init__(self, sensors: Sequence[Sensor], clock: Clock) -> None:
        """Subscribe; an InvalidValueError names a sensor whose type or field does not exist."""
        inputs = []
        for one in sensors:
            field = MessageField(one.message, one.field)
            inputs.append(SensorInput(one, field.read, clock))
            rospy.Subscriber(one.topic, field.message_class, inputs[-1].note, queue_size=1)
        self.sensors = AuxSensors(inputs, clock)
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
    pairs = [KeyValue(key, value) for key, value in values.items()]
    name = rospy.resolve_name(f"{STATUS_FOLDER}/{sensor.name}").strip("/")
    return DiagnosticStatus(level, f"{name}: value", str(message), "", pairs)


def _fields(datatype: str) -> Dict[str, str]:
    """Return the types of the fields of a message by their names; none of what is no message."""
    kind = roslib.message.get_message_class(datatype) if "/" in datatype else None
    return {} if kind is None else dict(zip(kind.__slots__, kind._slot_types))
