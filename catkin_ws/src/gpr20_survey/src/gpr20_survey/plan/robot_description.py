"""What a robot is, as its nodes describe themselves."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from typing import Any, Dict, Iterable, Mapping, Sequence

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import OTHER_LAUNCH, PART_SILENT, VERSIONS_DIFFER
from gpr20_common.message import Message, in_a_row
from gpr20_common.mid.codec import record_from
from gpr20_common.mid.node_facts import Hardware, NodeSoftware
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.survey_parameters import RobotTravel, Travel

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
