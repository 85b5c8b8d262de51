"""The ROS interface of the survey."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import rospy
from std_srvs.srv import Trigger, TriggerResponse

from gpr20_axis_driver.mid.axis_parameters import AxisParameters
from gpr20_common.errors import InvalidValueError
from gpr20_common.high import diagnostics
from gpr20_common.high.node import run_node
from gpr20_common.high.parameters import read_parameters
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.services import advertise
from gpr20_common.low.clock import Clock
from gpr20_common.mid.checks import number_between, positive_number
from gpr20_main_control.high.axis_link import AxisLink
from gpr20_main_control.high.device_links import (
    AnalyzerLink,
    HeightLink,
    StorageLink,
    utc_now_ns,
)
from gpr20_main_control.mid.coverage import Coverage
from gpr20_main_control.mid.main_control import MainControl
from gpr20_main_control.mid.robot import AxisId, Robot
from gpr20_main_control.mid.robot_facts import RobotFacts
from gpr20_main_control.mid.status_board import Status, StatusBoard
from gpr20_main_control.mid.survey_parameters import DEFAULT_POLARIZATIONS_DEG, SurveyParameters
from gpr20_main_control.mid.survey_settings import SurveySettings
from gpr20_main_control.mid.survey_state import SurveyState
from gpr20_msgs.msg import ControlStatus, Coordinates, SurveyCoverage, SurveyData
from gpr20_msgs.srv import (
    ResumeSurvey,
    ResumeSurveyResponse,
    SetSurveyParameters,
    SetSurveyParametersResponse,
    StartSurvey,
    StartSurveyResponse,
)

COORDINATE_RATE_HZ = 10.0
PROGRESS_RATE_HZ = 2.0
# The axes' own drivers read the same group of parameters; these belong to their nodes.
OTHER_AXIS_PARAMETERS = ("scene", "time_scale")
SHUTDOWN_LIMIT_S = 10.0
NO_TARGET = -1.0


@dataclass(frozen=True)
class TimeLimits:
    """How long the control waits for the answers of other nodes [s]."""

    analyzer_limit_s: float = 90.0
    height_limit_s: float = 10.0
    storage_limit_s: float = 90.0

    def __post_init__(self) -> None:
        for name in ("analyzer_limit_s", "height_limit_s", "storage_limit_s"):
            number_between(name, getattr(self, name), 0.1, 3600.0, "s")


class MainControlNode:
    """Services and topics of the survey."""

    def __init__(
        self,
        robot: Robot,
        facts: RobotFacts,
        settings: SurveySettings,
        clock: Clock,
    ) -> None:
        self._robot = robot
        self._simulated = facts.simulated
        self._status = rospy.Publisher("control_status", ControlStatus, queue_size=10, latch=True)
        self._target = rospy.Publisher("control_target_coordinate", Coordinates, queue_size=10)
        self._current = rospy.Publisher("control_current_coordinate", Coordinates, queue_size=10)
        self._progress = rospy.Publisher("control_survey_data", SurveyData, queue_size=10)
        self._coverage = rospy.Publisher(
            "survey_coverage", SurveyCoverage, queue_size=10, latch=True
        )
        self._board = StatusBoard(self._publish_change)
        self._control = MainControl(
            robot, facts, settings, self._board, clock, utc_now_ns, self._publish_coverage
        )
        self._publish_status(self._board.status)
        self._services = [
            advertise("set_survey_parameters", SetSurveyParameters, self._set_parameters),
            advertise("start_survey", StartSurvey, self._start),
            advertise("pause_survey", Trigger, self._pause),
            advertise("stop_survey", Trigger, self._stop),
            advertise("resume_survey", ResumeSurvey, self._resume),
        ]
        self._periodics = [
            Periodic(1.0 / COORDINATE_RATE_HZ, self._publish_current),
            Periodic(1.0 / PROGRESS_RATE_HZ, self._repeat_progress),
        ]
        self._diagnostics = diagnostics.Diagnostics(
            "simulated robot" if facts.simulated else "GPR-20", self._health
        )
        rospy.on_shutdown(lambda: self._control.shut_down(SHUTDOWN_LIMIT_S))

    def _set_parameters(self, request: Any) -> SetSurveyParametersResponse:
        message = request.parameters
        values = {name: getattr(message, name) for name in message.__slots__}
        values["polarizations_deg"] = tuple(message.polarizations_deg) or DEFAULT_POLARIZATIONS_DEG
        estimate = self._control.set_parameters(SurveyParameters(**values))
        return SetSurveyParametersResponse(
            success=True,
            message="accepted",
            total_points=estimate.total_points,
            estimated_time=rospy.Duration.from_sec(estimate.duration_s),
        )

    def _start(self, _request: Any) -> StartSurveyResponse:
        survey_id = self._control.start()
        return StartSurveyResponse(True, "started", survey_id)

    def _stop(self, _request: Any) -> TriggerResponse:
        return TriggerResponse(True, self._control.stop())

    def _pause(self, _request: Any) -> TriggerResponse:
        return TriggerResponse(True, self._control.pause())

    def _resume(self, request: Any) -> ResumeSurveyResponse:
        return ResumeSurveyResponse(True, self._control.resume(request.survey))

    def _publish_change(self, before: Status, after: Status) -> None:
        if (before.state, before.message) != (after.state, after.message):
            rospy.loginfo("%s: %s", after.state.name, after.message)
            self._publish_status(after)
        self._publish_target(after)
        self._publish_progress(after)

    def _publish_status(self, status: Status) -> None:
        message = ControlStatus()
        message.header.stamp = rospy.Time.now()
        message.code = int(status.state)
        message.message = status.message
        message.survey_id = status.survey_id
        message.simulated = self._simulated
        self._status.publish(message)

    def _publish_target(self, status: Status) -> None:
        message = Coordinates()
        message.header.stamp = rospy.Time.now()
        target = status.target
        message.x_mm = NO_TARGET if target is None else target.x_mm
        message.y_mm = NO_TARGET if target is None else target.y_mm
        message.z_deg = NO_TARGET if target is None else target.z_deg
        self._target.publish(message)

    def _publish_progress(self, status: Status) -> None:
        message = SurveyData()
        message.header.stamp = rospy.Time.now()
        message.survey_id = status.survey_id
        message.completion_percent = status.completion_percent
        message.total_points = status.total_points
        message.visited_points = status.visited_points
        message.remaining_points = status.total_points - status.visited_points
        message.remaining_time = rospy.Duration.from_sec(status.remaining_s)
        self._progress.publish(message)

    def _publish_coverage(self, coverage: Coverage) -> None:
        reasons = coverage.reasons
        message = SurveyCoverage()
        message.header.stamp = rospy.Time.now()
        message.survey_id = self._board.status.survey_id
        runs = coverage.runs()
        message.planned = len(coverage.states)
        message.run_starts = [start for start, _state in runs]
        message.run_states = bytes(state for _start, state in runs)
        message.failures = [f"{index}: {reasons[index]}" for index in sorted(reasons)]
        message.verdict = coverage.verdict().text
        self._coverage.publish(message)

    def _publish_current(self) -> None:
        readings = [axis.reading() for _axis_id, axis in self._robot.axes()]
        if any(reading is None for reading in readings):
            return
        message = Coordinates()
        message.header.stamp = rospy.Time.now()
        message.x_mm, message.y_mm, message.z_deg = (
            reading.coordinate for reading in readings if reading is not None
        )
        self._current.publish(message)

    def _repeat_progress(self) -> None:
        status = self._board.status
        self._publish_target(status)
        self._publish_progress(status)

    def _health(self) -> diagnostics.Health:
        status = self._board.status
        values = {
            "state": status.state.name,
            "survey": status.survey_id,
            "visited": f"{status.visited_points} of {status.total_points}",
        }
        level = diagnostics.OK
        if status.state is SurveyState.FAILED:
            level = diagnostics.ERROR
        elif status.state is SurveyState.PAUSED:
            level = diagnostics.WARN
        return level, status.message, values


def build_main_control_node() -> MainControlNode:
    """Read the parameters and build the control from the bottom up.

    Raises:
        Gpr20Error: A parameter is not allowed.
    """
    settings = read_parameters(SurveySettings, others=_names(TimeLimits))
    limits = read_parameters(TimeLimits, others=_names(SurveySettings))
    facts = RobotFacts(
        axes={axis_id: _axis_parameters(axis_id) for axis_id in AxisId},
        simulated=_simulated(),
        time_scale=positive_number("time_scale", float(rospy.get_param("time_scale", 1.0))),
    )
    robot = Robot(
        x=AxisLink("x_axis"),
        y=AxisLink("y_axis"),
        z=AxisLink("z_axis"),
        analyzer=AnalyzerLink(limits.analyzer_limit_s),
        height_sensor=HeightLink(limits.height_limit_s),
        storage=StorageLink(limits.storage_limit_s),
    )
    return MainControlNode(robot, facts, settings, Clock())


def _simulated() -> bool:
    simulated = rospy.get_param("simulated", None)
    if not isinstance(simulated, bool):
        place = rospy.resolve_name("simulated")
        raise InvalidValueError(
            f"parameter {place} is {simulated!r}; it must be true or false, as the launch files "
            "set it: recordings say by it whether they show real ground"
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
