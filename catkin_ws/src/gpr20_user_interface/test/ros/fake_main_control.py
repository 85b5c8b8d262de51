"""A main_control without a robot: keeps the contract of the graph, does as the test says."""

from __future__ import annotations

import json
import threading
import uuid
from pathlib import Path
from typing import Any, Dict, List, Optional, Type, Union

import rospkg
import rospy
from sensor_msgs.msg import Range

from gpr20_common.errors import Gpr20Error
from gpr20_common.high.services import advertise
from gpr20_common.low.yaml_file import read_yaml
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_common.sent_message import message_fields
from gpr20_msgs.msg import (
    ControlStatus,
    Coordinates,
    NodeDescription,
    RobotConfiguration,
    SurveyData,
)
from gpr20_msgs.msg import SurveyParameters as SurveyParametersMessage
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
from gpr20_survey.plan.annotation import EMPTY, from_fields
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel, check

TRAVEL = RobotTravel(
    x=Travel(0.0, 650.0, 0.01), y=Travel(0.0, 800.0, 0.01), z=Travel(-90.0, 90.0, 1.8)
)
ACTIVE = (
    ControlStatus.CHECKING,
    ControlStatus.HOMING,
    ControlStatus.SURVEYING,
    ControlStatus.PAUSING,
    ControlStatus.PAUSED,
    ControlStatus.STOPPING,
)
PERIOD_S = 0.5
ANSWER_LIMIT_S = 60.0
PAUSED_ON_REQUEST = verbatim("paused on request").with_fault(
    Fault("survey.paused_on_request", severity=Severity.NOTE)
)
STOPPED_ON_REQUEST = verbatim("stopped by request").with_fault(
    Fault("survey.stopped_on_request", severity=Severity.NOTE)
)


def robot_configuration() -> RobotConfiguration:
    """Return the description of the robot as it is built."""
    path = Path(rospkg.RosPack().get_path("gpr20_launch")) / "config" / "axes.yaml"
    configurations: Dict[str, Any] = {
        f"{axis}_axis/axis_driver": values for axis, values in read_yaml(path).items()
    }
    configurations["height_sensor"] = {}
    configurations["vna_acquisition"] = {"address": "127.0.0.1"}
    configurations["main_control"] = {}
    nodes = [
        NodeDescription(
            node=node, hardware="a test", time_scale=1.0, configuration_json=json.dumps(values)
        )
        for node, values in configurations.items()
    ]
    return RobotConfiguration(known=True, nodes=nodes, site_json="{}")


class FakeMainControl:
    """Takes one trace per `point_s`; a test may hold it, pause it, fail it and take it away."""

    def __init__(self, namespace: str, point_s: float = 0.05) -> None:
        self._namespace = namespace
        self._point_s = point_s
        self._lock = threading.RLock()
        self._closed = threading.Event()
        self._parameters: Optional[SurveyParameters] = None
        self._visited = 0
        self.code = ControlStatus.IDLE
        self.survey_id = ""
        self.starts = 0
        self.annotation = EMPTY
        self.permittivity = 0.0
        self.stops = 0
        self.may_stop = threading.Event()
        self.may_stop.set()
        self.may_pause = threading.Event()
        self.may_pause.set()
        # An answer to START that a test holds back, or makes a refusal.
        self.asked = 0
        self.may_answer = threading.Event()
        self.may_answer.set()
        self.refusal: Optional[Message] = None
        # The VNA that is connected, if it is not that of the survey.
        self.other_analyzer = ""
        self.resumed_with: List[str] = []
        # Points that the survey may take; a test that needs time gives them out slowly.
        self.point_limit = 10**6
        self._advertise()
        self._say(ControlStatus.IDLE, "waiting for parameters")
        threading.Thread(target=self._run, daemon=True).start()

    def describe_robot(self) -> None:
        self._configuration.publish(robot_configuration())

    @property
    def visited(self) -> int:
        return self._visited

    @property
    def parameters(self) -> SurveyParameters:
        if self._parameters is None:
            raise AssertionError("no parameters were set")
        return self._parameters

    def listeners(self) -> int:
        return self._data.get_num_connections()

    def watchers(self) -> int:
        return self._status.get_num_connections()

    def pause(self, message: Union[Message, str]) -> None:
        self._say(ControlStatus.PAUSED, message)

    def fail(self, message: str) -> None:
        self._say(ControlStatus.FAILED, message)

    def end_silently(self) -> None:
        """End the survey without a word, as if the word were still on its way."""
        self.code = ControlStatus.FINISHED

    def close(self) -> None:
        self._closed.set()
        for service in self._services:
            service.shutdown()
        for publisher in self._publishers():
            publisher.unregister()

    def _publishers(self) -> List[rospy.Publisher]:
        positions = [self._current, self._target, self._height]
        latched = [self._parameters_topic, self._configuration]
        return [self._status, self._data, *latched, *positions]

    def _advertise(self) -> None:
        def name(relative: str) -> str:
            return f"{self._namespace}/{relative}"

        # Clients believe the main control alone, and this process may have another name.
        as_main_control = {"callerid": name("main_control")}

        def publisher(
            topic: str, kind: Type, latch: bool = False, size: int = 10
        ) -> rospy.Publisher:
            return rospy.Publisher(
                name(topic), kind, latch=latch, queue_size=size, headers=as_main_control
            )

        self._status = publisher("control_status", ControlStatus, latch=True)
        self._data = publisher("control_survey_data", SurveyData)
        self._current = publisher("control_current_coordinate", Coordinates, size=1)
        self._target = publisher("control_target_coordinate", Coordinates, size=1)
        self._height = publisher("measured_height", Range, size=1)
        self._parameters_topic = publisher("survey_parameters", SurveyParametersMessage, latch=True)
        self._configuration = publisher("robot_configuration", RobotConfiguration, latch=True)
        self._services = [
            advertise(name("set_survey_parameters"), SetSurveyParameters, self._set),
            advertise(name("start_survey"), StartSurvey, self._start),
            advertise(name("stop_survey"), Command, self._stop),
            advertise(name("pause_survey"), Command, self._pause),
            advertise(name("resume_survey"), ResumeSurvey, self._resume),
        ]

    def _set(self, request: object) -> SetSurveyParametersResponse:
        message = request.parameters
        values = {name: getattr(message, name) for name in message.__slots__}
        parameters = SurveyParameters(**values)
        check(parameters, TRAVEL)
        with self._lock:
            self._refuse_while_active()
            self._parameters = parameters
            self._parameters_topic.publish(message)
            self._say(ControlStatus.CONFIGURED, "ready to start")
        estimate = rospy.Duration(parameters.total_points * self._point_s)
        return _answer(
            SetSurveyParametersResponse,
            "accepted",
            plan_id=parameters.plan_id,
            total_points=parameters.total_points,
            estimated_time=estimate,
        )

    def _start(self, request: Any) -> StartSurveyResponse:
        self.asked += 1
        if not self.may_answer.wait(ANSWER_LIMIT_S):
            raise Gpr20Error(verbatim("the test did not let the fake answer"))
        if self.refusal is not None:
            raise Gpr20Error(self.refusal)
        with self._lock:
            self._refuse_while_active()
            if self._parameters is None or request.plan_id != self._parameters.plan_id:
                raise Gpr20Error(verbatim(f"another plan than {request.plan_id!r} is set"))
            self.starts += 1
            self.annotation = from_fields(request.annotation)
            self.permittivity = request.permittivity
            self.survey_id = str(uuid.uuid4())
            self._visited = 0
            self._say(ControlStatus.CHECKING, "checking the devices")
        return _answer(StartSurveyResponse, "started", survey_id=self.survey_id)

    def _refuse_while_active(self) -> None:
        if self.code in ACTIVE:
            raise Gpr20Error(verbatim(f"survey {self.survey_id} is running; stop it first"))

    def _stop(self, _request: object) -> CommandResponse:
        with self._lock:
            self.stops += 1
            if self.code not in ACTIVE:
                raise Gpr20Error(verbatim("no survey runs"))
            self._say(ControlStatus.STOPPING, "axes ramp down")
        return _answer(CommandResponse, "stopping")

    def _pause(self, _request: object) -> CommandResponse:
        with self._lock:
            if self.code != ControlStatus.SURVEYING:
                raise Gpr20Error(verbatim("no survey is measuring; there is nothing to pause"))
            self._say(ControlStatus.PAUSING, "pausing after this sample")
        return _answer(CommandResponse, "pausing")

    def _resume(self, request: Any) -> ResumeSurveyResponse:
        self.resumed_with.append(request.accept_analyzer)
        if self.other_analyzer and request.accept_analyzer != self.other_analyzer:
            message = verbatim(f"the VNA is {self.other_analyzer}, but the survey began with A")
            fields = message_fields(message)
            return ResumeSurveyResponse(success=False, other_analyzer=self.other_analyzer, **fields)
        with self._lock:
            if self.code != ControlStatus.PAUSED:
                raise Gpr20Error(verbatim("no survey is paused"))
            self._say(ControlStatus.SURVEYING, "going on")
        return _answer(ResumeSurveyResponse, "going on")

    def _say(self, code: int, message: Union[Message, str]) -> None:
        fields = message_fields(message if isinstance(message, Message) else verbatim(message))
        with self._lock:
            self.code = code
            status = ControlStatus(code=code, survey_id=self.survey_id, simulated=True, **fields)
            status.header.stamp = rospy.Time.now()
            self._status.publish(status)
            self._publish_data()

    def _run(self) -> None:
        said_s = 0.0
        while not self._closed.wait(self._point_s):
            with self._lock:
                self._step()
                if rospy.get_time() - said_s >= PERIOD_S:
                    said_s = rospy.get_time()
                    self._publish_data()

    def _step(self) -> None:
        if self.code == ControlStatus.CHECKING:
            self._say(ControlStatus.SURVEYING, "visiting the planned points")
        elif self.code == ControlStatus.SURVEYING and self._visited < self.point_limit:
            self._visited += 1
            self._publish_data()
            if self._visited == self._parameters.total_points:
                self._say(ControlStatus.FINISHED, "every trace is stored in /data/survey")
        elif self.code == ControlStatus.PAUSING and self.may_pause.is_set():
            self._say(ControlStatus.PAUSED, PAUSED_ON_REQUEST)
        elif self.code == ControlStatus.STOPPING and self.may_stop.is_set():
            self._say(ControlStatus.STOPPED, STOPPED_ON_REQUEST)

    def _publish_data(self) -> None:
        total = self._parameters.total_points if self._parameters else 0
        remaining = total - self._visited
        self._data.publish(
            SurveyData(
                survey_id=self.survey_id,
                completion_percent=100.0 * self._visited / total if total else 0.0,
                total_points=total,
                visited_points=self._visited,
                remaining_points=remaining,
                remaining_time=rospy.Duration(remaining * self._point_s),
            )
        )
        at = float(self._visited)
        self._current.publish(Coordinates(x_mm=at, y_mm=2 * at, z_deg=90.0))
        running = self.code == ControlStatus.SURVEYING
        target = (at + 1, 2 * at, 90.0) if running else (-1.0, -1.0, -1.0)
        self._target.publish(Coordinates(rospy.Header(stamp=rospy.Time.now()), *target))
        self._height.publish(Range(min_range=0.1, max_range=0.8, range=0.312))


def _answer(response_class: Any, text: str, **fields: Any) -> Any:
    return response_class(success=True, **message_fields(verbatim(text)), **fields)
