"""The ROS interface of the survey."""

from __future__ import annotations

from functools import partial
from typing import Any, Callable, Dict, Tuple

import rosgraph
import rospy

from gpr20_common.high import diagnostics
from gpr20_common.high.answers import advertise, message_fields, record_of
from gpr20_common.high.node import read_parameters, run_node
from gpr20_common.high.periodic import Periodic
from gpr20_common.low.clock import Clock
from gpr20_common.low.links import NodeProbe
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain
from gpr20_common.mid.node_facts import NO_HARDWARE, own_software
from gpr20_main_control.errors import OtherAnalyzerError
from gpr20_main_control.high.ros_devices import (
    RosAnalyzer,
    RosAxis,
    RosStorage,
    height_over_ros,
)
from gpr20_main_control.high.sensor_topics import SensorTopics
from gpr20_main_control.high.survey_topics import SurveyTopics, listen_to_nodes
from gpr20_main_control.mid.devices.described_robot import NEEDED_NODES, DescribedRobot
from gpr20_main_control.mid.devices.node_liveness import SILENCE_LIMIT_S, NodeLiveness
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.main_control import MainControl
from gpr20_main_control.mid.service import axis_move
from gpr20_main_control.mid.survey.survey import Accepted
from gpr20_main_control.mid.survey.survey_status import SurveyStatus
from gpr20_msgs import srv
from gpr20_survey.axes import AxisId
from gpr20_survey.plan import annotation
from gpr20_survey.plan.annotation import Site
from gpr20_survey.plan.robot_description import SENSORS, SIMULATOR, NodeDescription, Sensors
from gpr20_survey.plan.survey_parameters import (
    DEFAULT_POLARIZATIONS_DEG,
    SurveyParameters,
    SurveySettings,
)
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.radar import requested_permittivity
from gpr20_survey.results.answers import AnalyzerTest

PUBLISHING_PERIOD_S = 0.1
NODE = "main_control"
SHUTDOWN_LIMIT_S = 10.0
# What an answer says, and its other fields.
Said = Tuple[Message, Dict[str, Any]]


class MainControlNode:
    """Services and topics of the survey."""

    def __init__(
        self, control: MainControl, robot: Robot, status: SurveyStatus, topics: SurveyTopics
    ) -> None:
        self._control, self._status = control, status
        for name, kind, handle in (
            ("set_survey_parameters", srv.SetSurveyParameters, self._set_parameters),
            ("start_survey", srv.StartSurvey, self._start),
            ("pause_survey", srv.Command, lambda _request: (control.pause(), {})),
            ("stop_survey", srv.Command, lambda _request: (control.stop(), {})),
            ("resume_survey", srv.ResumeSurvey, self._resume),
            ("service_move", srv.ServiceMove, self._service_move),
            ("daily_check", srv.DailyCheck, self._daily_check),
        ):
            advertise(name, kind, partial(_answer, kind, handle))
        advertise("test_analyzer", srv.TestAnalyzer, self._test_analyzer)
        # After the services: clients that receive the status call them.
        topics.publish_status(status.status)
        topics.publish_service(None)
        publish = lambda: topics.publish(robot, status.status)  # noqa: E731
        self._periodic = Periodic(PUBLISHING_PERIOD_S, publish)
        self._diagnostics = diagnostics.Diagnostics(robot.description.site.robot, self._health)
        # First: nodes that are shut down too are no faults.
        rospy.on_shutdown(robot.nodes.stop)
        rospy.on_shutdown(lambda: control.shut_down(SHUTDOWN_LIMIT_S))

    def _set_parameters(self, request: Any) -> Said:
        rotations_deg = tuple(request.parameters.polarizations_deg) or DEFAULT_POLARIZATIONS_DEG
        parameters = record_of(
            SurveyParameters, request.parameters, polarizations_deg=rotations_deg
        )
        plan = self._control.set_parameters(parameters, _caller(request))
        return Message("Parameters accepted"), {
            "plan_id": plan.parameters.plan_id,
            "total_points": plan.total_points,
            "estimated_time": rospy.Duration.from_sec(plan.duration_s),
        }

    def _start(self, request: Any) -> Said:
        added = annotation.from_fields(request.annotation)
        permittivity = requested_permittivity(request.permittivity)
        survey_id = self._control.start(added, request.refines, permittivity, request.plan_id)
        return Message("Survey started"), {"survey_id": survey_id}

    def _resume(self, request: Any) -> Said:
        try:
            accepted = Accepted(request.accept_analyzer, request.accept_zeros)
            return self._control.resume(request.survey, accepted), {}
        except OtherAnalyzerError as error:
            return error.message, {"success": False, "other_analyzer": error.identity}

    def _service_move(self, request: Any) -> Said:
        move = axis_move(request.axis, request.action, request.distance)
        return self._control.move_for_service(move), {}

    def _test_analyzer(self, request: Any) -> srv.TestAnalyzerResponse:
        test = self._control.test_analyzer(request.address)
        return srv.TestAnalyzerResponse(**analyzer_test_fields(test))

    def _daily_check(self, request: Any) -> Said:
        verdict = self._control.daily_check(request.step, _caller(request))
        if verdict is None:
            return Message("Swept twice."), {}
        return verdict.message, {"good": verdict.good}

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


def analyzer_test_fields(test: AnalyzerTest) -> Dict[str, Any]:
    """Return the fields of an answer of `test_analyzer`."""
    found = dict(vars(test))
    failure = found.pop("failure")
    said = message_fields(failure or Message("The VNA works."))
    return {"success": failure is None, **said, **found}


def _answer(kind: Any, handle: Callable[[Any], Said], request: Any) -> Any:
    said, fields = handle(request)
    return kind._response_class(**{"success": True, **message_fields(said), **fields})


def _caller(request: Any) -> str:
    """Return the name of the node that has sent a request."""
    return str(request._connection_header.get("callerid", ""))


def build_main_control_node() -> MainControlNode:
    """Read the parameters and build the main control from the bottom up."""
    settings = read_parameters(SurveySettings, "survey")
    clock = Clock()
    sensors = SensorTopics(read_parameters(Sensors, SENSORS).sensors, clock)
    topics = SurveyTopics()
    status = SurveyStatus(topics.publish_change, topics.publish_parameters, topics.publish_coverage)
    nodes = NodeLiveness(clock, lambda missing: status.update(missing=missing))
    for name, plain_name in NEEDED_NODES.items():
        nodes.watch(name, plain_name, _probe(name))

    def describe(description: DescribedRobot) -> None:
        simulated = description.problem is None and description.config().simulated
        if simulated:
            nodes.watch(SIMULATOR, Message("the simulated robot"), _probe(SIMULATOR))
        topics.publish_robot(description)
        if simulated != topics.simulated:
            topics.simulated = simulated
            topics.publish_status(status.status)

    description = DescribedRobot(read_parameters(Site, "site"), describe)
    robot = Robot(
        axes={axis_id: RosAxis(axis_id, clock) for axis_id in AxisId},
        analyzer=RosAnalyzer(),
        height_m=height_over_ros(),
        storage=RosStorage(topics),
        nodes=nodes,
        description=description,
        sensors=sensors.sensors,
    )
    control = MainControl(
        robot, settings, status, clock, description.site.annotation, topics.publish_service
    )
    node = MainControlNode(control, robot, status, topics)
    description.note(NodeDescription(NODE, NO_HARDWARE, plain(settings), own_software()))
    listen_to_nodes(description.note)
    return node


def _probe(name: str) -> Callable[[], int]:
    master_uri, own_name = rosgraph.get_master_uri(), rospy.get_name()
    return NodeProbe(master_uri, own_name, rospy.resolve_name(name), SILENCE_LIMIT_S).process


def main() -> None:
    run_node(NODE, build_main_control_node)
