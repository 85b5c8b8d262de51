"""The ROS interface of the survey."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import rosgraph
import rospy

from gpr20_common.errors import InvalidValueError
from gpr20_common.high import diagnostics
from gpr20_common.high.graph_message import message_fields
from gpr20_common.high.node import run_node
from gpr20_common.high.parameters import read_parameters
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.services import advertise
from gpr20_common.low.clock import Clock
from gpr20_common.low.node_probe import NodeProbe
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between, positive_number
from gpr20_main_control.high.node_names import plain_names
from gpr20_main_control.high.ros_axis import RosAxis
from gpr20_main_control.high.ros_devices import RosAnalyzer, RosHeightSensor, RosStorage
from gpr20_main_control.high.survey_topics import SurveyTopics
from gpr20_main_control.mid.main_control import MainControl
from gpr20_main_control.mid.node_liveness import ANSWER_LIMIT_S, NodeLiveness, WatchedNode
from gpr20_main_control.mid.robot import Robot
from gpr20_main_control.mid.survey_status import SurveyStatus
from gpr20_msgs.srv import (
    Command,
    CommandResponse,
    ResumeSurvey,
    ResumeSurveyResponse,
    SetSurveyParameters,
    SetSurveyParametersResponse,
    StartSurvey,
    StartSurveyResponse,
)
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_parameters import DEFAULT_POLARIZATIONS_DEG, SurveyParameters
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState

COORDINATE_RATE_HZ = 10.0
PROGRESS_RATE_HZ = 2.0
# The axis drivers read the same group of parameters; these are for the drivers alone.
OTHER_AXIS_PARAMETERS = ("scene", "time_scale")
SHUTDOWN_LIMIT_S = 10.0


@dataclass(frozen=True)
class TimeLimits:
    """How long the main control waits for the answers of other nodes [s]."""

    analyzer_limit_s: float = 90.0
    height_limit_s: float = 10.0
    storage_limit_s: float = 90.0

    def __post_init__(self) -> None:
        for name in ("analyzer_limit_s", "height_limit_s", "storage_limit_s"):
            number_between(name, getattr(self, name), 0.1, 3600.0, "s")


class MainControlNode:
    """Services and topics of the survey."""

    def __init__(
        self, control: MainControl, robot: Robot, status: SurveyStatus, topics: SurveyTopics
    ) -> None:
        self._control = control
        self._status = status
        self._topics = topics
        self._services = [
            advertise("set_survey_parameters", SetSurveyParameters, self._set_parameters),
            advertise("start_survey", StartSurvey, self._start),
            advertise("pause_survey", Command, self._pause),
            advertise("stop_survey", Command, self._stop),
            advertise("resume_survey", ResumeSurvey, self._resume),
        ]
        # After the services: clients that receive the status call them.
        topics.publish_status(status.status)
        self._periodics = [
            Periodic(1.0 / COORDINATE_RATE_HZ, lambda: topics.publish_current(robot)),
            Periodic(1.0 / PROGRESS_RATE_HZ, lambda: topics.publish_progress(status.status)),
        ]
        self._diagnostics = diagnostics.Diagnostics(
            "simulated robot" if topics.simulated else "GPR-20", self._health
        )
        rospy.on_shutdown(lambda: control.shut_down(SHUTDOWN_LIMIT_S))
        rospy.on_shutdown(robot.nodes.stop)
        robot.nodes.start()

    def _set_parameters(self, request: Any) -> SetSurveyParametersResponse:
        message = request.parameters
        values = {name: getattr(message, name) for name in message.__slots__}
        values["polarizations_deg"] = tuple(message.polarizations_deg) or DEFAULT_POLARIZATIONS_DEG
        plan = self._control.set_parameters(SurveyParameters(**values))
        return SetSurveyParametersResponse(
            success=True,
            total_points=plan.total_points,
            estimated_time=rospy.Duration.from_sec(plan.duration_s),
            **message_fields(Message("Parameters accepted")),
        )

    def _start(self, _request: Any) -> StartSurveyResponse:
        survey_id = self._control.start()
        started = message_fields(Message("Survey started"))
        return StartSurveyResponse(success=True, survey_id=survey_id, **started)

    def _stop(self, _request: Any) -> CommandResponse:
        return CommandResponse(success=True, **message_fields(self._control.stop()))

    def _pause(self, _request: Any) -> CommandResponse:
        return CommandResponse(success=True, **message_fields(self._control.pause()))

    def _resume(self, request: Any) -> ResumeSurveyResponse:
        resuming = self._control.resume(request.survey)
        return ResumeSurveyResponse(success=True, **message_fields(resuming))

    def _health(self) -> diagnostics.Health:
        status = self._status.status
        values = {
            "state": status.state.name,
            "survey": status.survey_id,
            "visited": f"{status.visited_points} of {status.total_points}",
        }
        level = diagnostics.OK
        if status.state is SurveyState.FAILED:
            level = diagnostics.ERROR
        elif status.state is SurveyState.PAUSED or status.missing is not None:
            level = diagnostics.WARN
        return level, status.full_message, values


def build_main_control_node() -> MainControlNode:
    """Read the parameters and build the main control from the bottom up.

    Raises:
        Gpr20Error: A parameter is not allowed.
    """
    settings = read_parameters(SurveySettings, others=_names(TimeLimits))
    limits = read_parameters(TimeLimits, others=_names(SurveySettings))
    config = RobotConfig(
        axes={axis_id: _axis_parameters(axis_id) for axis_id in AxisId},
        simulated=_simulated(),
        time_scale=positive_number("time_scale", float(rospy.get_param("time_scale", 1.0))),
    )
    clock = Clock()
    topics = SurveyTopics(config.simulated)
    status = SurveyStatus(topics.publish_change, topics.publish_parameters, topics.publish_coverage)
    robot = Robot(
        axes={axis_id: RosAxis(axis_id, clock) for axis_id in AxisId},
        analyzer=RosAnalyzer(limits.analyzer_limit_s),
        height_sensor=RosHeightSensor(limits.height_limit_s),
        storage=RosStorage(limits.storage_limit_s, topics),
        nodes=_nodes(config.simulated, clock, status),
    )
    control = MainControl(robot, config, settings, status, clock)
    return MainControlNode(control, robot, status, topics)


def _nodes(simulated: bool, clock: Clock, status: SurveyStatus) -> NodeLiveness:
    master_uri, own_name = rosgraph.get_master_uri(), rospy.get_name()
    nodes = {}
    for name, plain_name in plain_names(simulated).items():
        full_name = rospy.resolve_name(name)
        probe = NodeProbe(master_uri, own_name, full_name, ANSWER_LIMIT_S)
        nodes[name] = WatchedNode(plain_name, probe.process)
    return NodeLiveness(nodes, clock, status.set_missing)


def _simulated() -> bool:
    simulated = rospy.get_param("simulated", None)
    if not isinstance(simulated, bool):
        place = rospy.resolve_name("simulated")
        raise InvalidValueError(
            Message(
                "parameter {place} is {value}; it must be true or false, as the launch files set "
                "it, because recordings state whether they show real ground",
                place=place,
                value=repr(simulated),
            )
        )
    return simulated


def _axis_parameters(axis_id: AxisId) -> AxisParameters:
    group = f"{axis_id.value}_axis/axis_driver"
    return read_parameters(AxisParameters, group, others=OTHER_AXIS_PARAMETERS)


def _names(record_class: Any) -> Any:
    return record_class.__dataclass_fields__.keys()


def main() -> None:
    """Run the main control."""
    run_node("main_control", build_main_control_node)
