"""What a robot is, as its nodes describe themselves."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass, field
from typing import Any, Dict, Iterable, Iterator, Mapping, Optional, Sequence, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, OTHER_LAUNCH, PART_SILENT, VERSIONS_DIFFER
from gpr20_common.message import Message, in_a_row
from gpr20_common.mid.codec import bounded, record_from
from gpr20_common.mid.node_facts import Hardware, NodeSoftware
from gpr20_survey.axes import AxisId, AxisParameters
from gpr20_survey.plan.survey_parameters import RobotTravel, Travel
from gpr20_survey.trace.trace import (
    AUX_NAME,
    AUX_UNIT,
    MAX_AUX_VALUES,
    MAX_UNIT_CHARACTERS,
    VNA_TEMPERATURE,
)

HEIGHT_SENSOR = "height_sensor"
ANALYZER = "vna_acquisition"
STORAGE = "vna_processing"
SIMULATOR = "simulator"
# What operators call the nodes that measure; all of them must be simulated, or none.
PLAIN_NAMES: Dict[str, Message] = {
    **{
        f"{axis_id.value}_axis/axis_driver": Message("the {axis} axis driver", axis=axis_id.value)
        for axis_id in AxisId
    },
    HEIGHT_SENSOR: Message("the height sensor"),
    ANALYZER: Message("the VNA driver"),
}
STORAGE_NAME = Message("the storage")
# The identity of every simulated analyzer contains it.
SIMULATED_IDENTITY = "SIMULATED"
# Section of the configuration, and entry of the description.
SENSORS = "sensors"
# Relative or absolute; a private name would be below the name of the node that reads it.
TOPIC = re.compile(r"/?[A-Za-z]\w*(/[A-Za-z]\w*)*", re.ASCII)
MESSAGE = re.compile(r"[A-Za-z]\w*/[A-Za-z]\w*", re.ASCII)
FIELD = re.compile(r"[A-Za-z]\w*(\[\d{1,6}\])?(\.[A-Za-z]\w*(\[\d{1,6}\])?)*", re.ASCII)


@dataclass(frozen=True)
class NodeDescription:
    """What one node is: its name below the robot's namespace, and the parameters of its start."""

    node: str
    hardware: Hardware
    configuration: Mapping[str, Any]
    software: NodeSoftware = field(default_factory=NodeSoftware)

    @classmethod
    def from_fields(cls, fields: Any) -> NodeDescription:
        """Return the description of a ROS message gpr20_msgs/NodeDescription.

        Raises:
            ValueError: Its configuration is not JSON.
        """
        hardware = Hardware(fields.hardware, fields.simulated, fields.time_scale)
        software = NodeSoftware(fields.version, fields.revision, fields.host)
        return cls(fields.node, hardware, json.loads(fields.configuration_json), software)

    def fields(self) -> Dict[str, Any]:
        return {
            "node": self.node,
            "hardware": self.hardware.name,
            "simulated": self.hardware.simulated,
            "time_scale": self.hardware.time_scale,
            "configuration_json": json.dumps(dict(self.configuration)),
            **asdict(self.software),
        }


@dataclass(frozen=True)
class RobotConfig:
    """What is fixed for one robot; a simulated one runs `time_scale` times faster."""

    axes: Dict[AxisId, AxisParameters]
    simulated: bool
    time_scale: float = 1.0

    @property
    def travel(self) -> RobotTravel:
        axes = [self.axes[axis_id] for axis_id in AxisId]
        return RobotTravel(*(Travel(one.min_coord, one.max_coord, one.step_size) for one in axes))


def robot_config(nodes: Mapping[str, NodeDescription]) -> RobotConfig:
    """Return what is fixed for a robot, by the descriptions received so far.

    Raises:
        InvalidValueError: A node has not described itself, some are simulated and others are
            not, or an axis has other parameters than this version knows.
    """
    _refuse_missing(PLAIN_NAMES, nodes)
    _refuse_mixed(nodes)
    hardware = nodes[ANALYZER].hardware
    axes = {axis_id: axis_parameters(axis_id, nodes) for axis_id in AxisId}
    return RobotConfig(axes, hardware.simulated, hardware.time_scale)


def axis_parameters(axis_id: AxisId, nodes: Mapping[str, NodeDescription]) -> AxisParameters:
    """Return the parameters of one axis.

    Raises:
        InvalidValueError: The axis driver has not described itself, or has other parameters than
            this version knows.
    """
    name = f"{axis_id.value}_axis/axis_driver"
    _refuse_missing([name], nodes)
    try:
        return record_from(AxisParameters, nodes[name].configuration, name)
    except InvalidValueError as error:
        raise InvalidValueError(error.message, fault=VERSIONS_DIFFER) from error


def is_simulated_identity(identity: str) -> bool:
    return SIMULATED_IDENTITY in identity.upper()


def _refuse_missing(needed: Iterable[str], nodes: Mapping[str, NodeDescription]) -> None:
    missing = [name for name in needed if name not in nodes]
    if missing:
        raise InvalidValueError(
            Message(
                "{parts}: no description of its hardware has arrived; check that it runs",
                parts=_joined(missing),
                details=", ".join(missing),
            ),
            fault=PART_SILENT,
        )


def _refuse_mixed(nodes: Mapping[str, NodeDescription]) -> None:
    simulated = [name for name in PLAIN_NAMES if nodes[name].hardware.simulated]
    real = [name for name in PLAIN_NAMES if not nodes[name].hardware.simulated]
    if simulated and real:
        raise InvalidValueError(
            Message(
                "simulated: {simulated}; real: {real}; a survey needs parts of one kind: end "
                "every launch and start one",
                simulated=_joined(simulated),
                real=_joined(real),
            ),
            fault=OTHER_LAUNCH,
        )


def _joined(names: Sequence[str]) -> Message:
    return in_a_row([PLAIN_NAMES[name] for name in names])


@dataclass(frozen=True)
class Sensor:
    """One value of one other sensor.

    Attributes:
        name: Name of the value in traces and exports: a-z, 0-9 and _, such as soil_moisture.
        topic: Topic on which the sensor's node publishes, relative to the robot's namespace.
        message: Type of its messages, such as std_msgs/Float64.
        field: Field that holds the value, such as data, or a.b[0] inside other fields.
        unit: Unit of the value, such as degC.
        longest_age_s: A value that was received longer ago than this counts as silence [s].
        required: true: the survey pauses when the sensor is silent or its value is not plausible;
            false: the trace gets a remark.
        low: Lowest plausible value; leave it out if there is none.
        high: Highest plausible value; leave it out if there is none.
    """

    name: str
    topic: str
    message: str
    field: str
    unit: str = ""
    longest_age_s: float = bounded(0.05, 3600.0, 5.0)
    required: bool = False
    low: Optional[float] = None
    high: Optional[float] = None

    def __post_init__(self) -> None:
        for mistake in self._mistakes():
            raise InvalidValueError(mistake, fault=CONFIGURATION)

    def _mistakes(self) -> Iterator[Message]:
        for key, pattern, example in (
            ("name", AUX_NAME, "soil_moisture"),
            ("topic", TOPIC, "soil_probe/moisture"),
            ("message", MESSAGE, "std_msgs/Float64"),
            ("field", FIELD, "data"),
        ):
            value = getattr(self, key)
            if not pattern.fullmatch(value):
                yield Message(
                    "{key} of sensor {sensor} is {value}; it must be like {example}",
                    key=key,
                    sensor=repr(self.name[:64]),
                    value=repr(value[:64]),
                    example=example,
                )
        if not AUX_UNIT.holds(self.unit):
            yield Message(
                "unit of sensor {sensor} is {value}; it must be printable and have at most {most} "
                "characters",
                sensor=self.name,
                value=repr(self.unit[:64]),
                most=MAX_UNIT_CHARACTERS,
            )
        if self.low is not None and self.high is not None and self.low >= self.high:
            yield Message(
                "low and high of sensor {sensor} are {low:g} and {high:g}; low must be below high",
                sensor=self.name,
                low=self.low,
                high=self.high,
            )

    def is_plausible(self, value: float) -> bool:
        return (self.low is None or value >= self.low) and (self.high is None or value <= self.high)


@dataclass(frozen=True)
class Sensors:
    """The other sensors of a robot.

    Attributes:
        sensors: One group of keys for each value that is stored with every trace.
    """

    sensors: Tuple[Sensor, ...] = ()

    def __post_init__(self) -> None:
        names = [VNA_TEMPERATURE, *(one.name for one in self.sensors)]
        if len(names) > MAX_AUX_VALUES:
            message = Message(
                "there are {count} sensors; at most {most} are allowed",
                count=len(self.sensors),
                most=MAX_AUX_VALUES - 1,
            )
            raise InvalidValueError(message, fault=CONFIGURATION)
        for name in names:
            if names.count(name) > 1:
                raise InvalidValueError(
                    Message("two sensors have the name {name}; give each its own", name=name),
                    fault=CONFIGURATION,
                )

    @property
    def topics(self) -> Tuple[str, ...]:
        return tuple(one.topic for one in self.sensors)
